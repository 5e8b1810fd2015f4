// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/help_panel.h"

#include <imgui.h>

namespace dpl {

void drawHelp(ViewerState& state, float width, float height) {
    if (!state.help) return;
    static constexpr const char* kWays[][2] = {
        {"drag", "turn around the middle"},
        {"right or middle button", "move sideways; shift and drag too"},
        {"wheel", "nearer to the cursor, farther"},
        {"double click", "turn around this place, from nearer"},
        {"1  2  3", "body, face, one hand, then the other"},
        {"F", "show everything"},
        {"O", "open a file"},
        {"left, right", "the next photograph, while comparing"},
        {"space", "play, pause"},
        {"H", "hide or show the panels"},
        {"E", "export pictures, videos, files"},
        {"P", "save a picture without panels"},
        {"L", "what was said until now"},
        {"F1", "this list"},
    };
    ImGui::SetNextWindowPos({width / 2, height / 2}, ImGuiCond_Always, {0.5f, 0.5f});
    bool open = true;
    ImGui::Begin(
        "Keys and mouse", &open,
        ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
    if (ImGui::BeginTable("ways", 2, ImGuiTableFlags_SizingFixedFit)) {
        for (const auto& way : kWays)
            for (const char* text : way) {
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(text);
            }
        ImGui::EndTable();
    }
    ImGui::End();
    state.help = open;
}

}  // namespace dpl
