// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/messages_panel.h"

#include <imgui.h>

#include <algorithm>
#include <cfloat>

#include "apps/viewer/panel_style.h"

namespace dpl {

void drawMessages(ViewerState& state, float width, float height) {
    if (state.messages.lines().empty()) return;
    const float wide = std::min(640.0f, width - 2 * kPanelGap);
    const bool bar = state.panels && state.player();
    ImGui::SetNextWindowPos({width / 2, height - kPanelGap - (bar ? kTimelineHeight + kPanelGap : 0)}, ImGuiCond_Always, {0.5f, 1});
    ImGui::SetNextWindowSizeConstraints({wide, 0}, {wide, FLT_MAX});
    ImGui::Begin("##messages", nullptr,
                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoTitleBar |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing);
    std::optional<size_t> dismissed;
    for (size_t i = 0; i < state.messages.lines().size(); ++i) {
        const Messages::Line& line = state.messages.lines()[i];
        ImGui::PushID(int(i));
        if (line.error) {
            if (ImGui::SmallButton("x")) dismissed = i;
            ImGui::SameLine();
            ImGui::PushStyleColor(ImGuiCol_Text, kErrorColour);
        }
        ImGui::TextWrapped("%s", line.text.c_str());
        if (line.error) ImGui::PopStyleColor();
        ImGui::PopID();
    }
    ImGui::End();
    if (dismissed) state.messages.dismiss(*dismissed);
}

}  // namespace dpl
