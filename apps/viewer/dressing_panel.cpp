// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/dressing_panel.h"

#include <imgui.h>

#include <algorithm>

namespace dpl {

void drawDressing(ViewerState& state) {
    const ViewedSubject* wearer = state.chosen();
    const auto gives = [&](const ViewedSubject& subject) { return &subject != wearer && canDress(subject); };
    if (!wearer || !canDress(*wearer) || std::none_of(state.subjects.begin(), state.subjects.end(), gives)) return;
    if (!ImGui::CollapsingHeader("Dress")) return;
    bool any = false;
    for (size_t i = 0; i < kGarments.size(); ++i) {
        ImGui::PushID(int(i));
        const ViewedSubject* giver = nullptr;
        for (const ViewedSubject& subject : state.subjects)
            if (state.outfit[i] && gives(subject) && subject.avatar.handle() == state.outfit[i]) giver = &subject;
        any |= giver != nullptr;
        ImGui::AlignTextToFramePadding();
        ImGui::TextUnformatted(kGarments[i]);
        ImGui::SameLine(70);
        if (ImGui::BeginCombo("##of", giver ? giver->file.c_str() : "their own")) {
            if (ImGui::Selectable("their own", !giver)) state.outfit[i] = nullptr;
            for (const ViewedSubject& subject : state.subjects) {
                if (!gives(subject)) continue;
                ImGui::PushID(subject.avatar.handle());
                if (ImGui::Selectable(subject.file.c_str(), giver == &subject)) state.outfit[i] = subject.avatar.handle();
                ImGui::PopID();
            }
            ImGui::EndCombo();
        }
        ImGui::PopID();
    }
    ImGui::BeginDisabled(!any || state.exports.running);
    if (ImGui::Button("Put on", {-1, 0})) state.wantsDress = true;
    ImGui::EndDisabled();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Makes a new avatar, in some ten seconds, and opens it; its file goes where exports go");
}

}  // namespace dpl
