// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_panel.h"

#include <imgui.h>

#include <cfloat>

#include "apps/viewer/new_run_panel.h"
#include "reconstruction/base/time_words.h"

namespace dpl {

void drawRun(ViewerState& state, bool pictureBeside) {
    WatchedRun& run = *state.run;
    const RunProgress& told = run.watch.progress();
    const RunWatch::Life life = run.watch.life(state.nowS);
    ImGui::TextWrapped("%s", run.watch.sentence(state.nowS).c_str());
    if (life == RunWatch::Life::Running) {
        const std::string whole = wordsOfTheRest(told);
        std::string text = formatText("{} %", int(100 * told.share));
        if (told.secondsLeft) text += ", " + wordsOfTimeLeft(*told.secondsLeft);
        ImGui::PushStyleColor(ImGuiCol_PlotHistogram, ImVec4(0.16f, 0.5f, 0.3f, 1));  // white letters are read on it
        ImGui::ProgressBar(float(told.share), {-1, 0}, text.c_str());
        ImGui::PopStyleColor();
        if (!told.detail.empty() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", told.detail.c_str());
        if (!whole.empty()) ImGui::TextWrapped("%s", whole.c_str());
    }
    if (life == RunWatch::Life::Done && run.finished) ImGui::TextWrapped("report.html in its folder says what the avatar is worth.");
    if (told.curve.size() > 1) {
        const auto at = [](void* points, int i) { return float(static_cast<const RunProgress::Point*>(points)[i].db); };
        ImGui::PlotLines("##fit", at, const_cast<RunProgress::Point*>(told.curve.data()), int(told.curve.size()), 0,
                         run.watch.wordsOfFit().c_str(), FLT_MAX, FLT_MAX, {0, 72});
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip("How closely the avatar resembles the pictures that it learns from: higher is closer");
    }
    if (run.heldBack.id != 0)
        ImGui::TextWrapped(pictureBeside ? "Beside it: picture %s, which it does not learn from"
                                         : "A wider window shows picture %s, which it does not learn from",
                           run.heldBackFrame.c_str());
    if (run.avatar && !run.finished) ImGui::Checkbox("turn slowly", &run.turns);
    drawRunControls(state);
}

}  // namespace dpl
