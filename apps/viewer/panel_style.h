// SPDX-License-Identifier: Apache-2.0
// Colours, sizes and words that the panels share.
#pragma once

#include <imgui.h>

namespace dpl {

inline const ImVec4 kErrorColour{1.0f, 0.52f, 0.45f, 1}, kQuietColour{0.62f, 0.66f, 0.72f, 1};

constexpr float kPanelGap = 12, kTimelineHeight = 46;  // in ImGui's coordinates

/** A line that does not ask for attention. */
inline void quiet(const char* format, double a = 0, double b = 0) {
    ImGui::PushStyleColor(ImGuiCol_Text, kQuietColour);
    ImGui::Text(format, a, b);
    ImGui::PopStyleColor();
}

}  // namespace dpl
