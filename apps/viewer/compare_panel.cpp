// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/compare_panel.h"

#include <imgui.h>

#include <cmath>

namespace dpl {

void drawComparison(ViewerState& state) {
    ComparedAvatar& compared = *state.compared;
    Comparison& comparison = compared.comparison;
    if (comparison.frames().empty()) {
        ImGui::TextWrapped("Looking for its pictures ...");
    } else {
        ImGui::TextWrapped("%s", comparison.frames()[comparison.frame()].c_str());
        int frame = int(comparison.frame()) + 1;
        const int count = int(comparison.frames().size());
        if (ImGui::ArrowButton("##before", ImGuiDir_Left)) comparison.step(-1);
        ImGui::SameLine();
        if (ImGui::ArrowButton("##after", ImGuiDir_Right)) comparison.step(1);
        ImGui::SameLine();
        if (ImGui::SliderInt("##frame", &frame, 1, count, ("%d of " + std::to_string(count)).c_str(), ImGuiSliderFlags_AlwaysClamp))
            comparison.choose(size_t(frame - 1));
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("The arrow keys step too");
        using Way = Comparison::Way;
        for (const auto& [way, name, help] : {std::tuple(Way::Wipe, "wipe", "The photograph, and the avatar to the right of the line"),
                                              {Way::Beside, "beside", "The photograph, and the avatar beside it"},
                                              {Way::Error, "error", "What differs: black nothing, then blue, red, yellow, white much"}}) {
            if (way != Way::Wipe) ImGui::SameLine();
            if (ImGui::RadioButton(name, comparison.way == way)) comparison.way = way;
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", help);
        }
        if (comparison.way != Way::Beside) {
            ImGui::SliderFloat("##wipe", &comparison.wipe, 0, 1, "", ImGuiSliderFlags_AlwaysClamp);
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("How much of the photograph is seen; drag on the picture does it too");
        }
        if (!compared.problem.empty())
            ImGui::TextWrapped("%s", compared.problem.c_str());
        else if (!comparison.isShown() || compared.photo.id == 0)
            ImGui::TextUnformatted("Drawing ...");
        else if (std::isfinite(compared.db))
            ImGui::TextWrapped(compared.masked ? "%.1f dB on the person" : "%.1f dB where the avatar is; this scan has no masks",
                               compared.db);
        else
            ImGui::TextUnformatted("no difference");
    }
    if (ImGui::Button("End comparing", {-1, 0})) state.wantsCompareEnd = true;
}

}  // namespace dpl
