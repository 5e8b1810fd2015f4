// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/log_panel.h"

#include <imgui.h>

#include <algorithm>

#include "apps/viewer/panel_style.h"

namespace dpl {

void drawLog(ViewerState& state, float width, float height) {
    if (!state.log) return;
    bool open = true;
    ImGui::SetNextWindowPos({width / 2, height / 2}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({std::min(640.0f, width - 24), std::min(420.0f, height - 24)}, ImGuiCond_Always);
    ImGui::Begin("Log", &open,
                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
    const auto& lines = state.messages.log();
    ImGui::BeginDisabled(lines.empty());
    if (ImGui::Button("Copy all")) {
        std::string all;
        for (const Messages::Kept& line : lines) all += line.text + '\n';
        ImGui::SetClipboardText(all.c_str());
    }
    ImGui::EndDisabled();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("For a letter to somebody who can help");
    ImGui::BeginChild("lines");
    if (lines.empty()) quiet("Nothing was said yet.");
    for (const Messages::Kept& line : lines) {
        quiet("%.0f s", line.atS);
        ImGui::SameLine(64);
        ImGui::PushStyleColor(ImGuiCol_Text, line.error ? kErrorColour : ImGui::GetStyleColorVec4(ImGuiCol_Text));
        ImGui::TextWrapped("%s", line.text.c_str());
        ImGui::PopStyleColor();
    }
    if (ImGui::GetScrollY() >= ImGui::GetScrollMaxY()) ImGui::SetScrollHereY(1);  // follows, unless somebody reads further up
    ImGui::EndChild();
    ImGui::End();
    state.log = open;
}

}  // namespace dpl
