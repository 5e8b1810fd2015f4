// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/panels.h"

#include <imgui.h>

#include <algorithm>

#include "apps/viewer/compare_panel.h"
#include "apps/viewer/new_run_panel.h"
#include "apps/viewer/panel_style.h"
#include "apps/viewer/picture_panel.h"
#include "apps/viewer/run_panel.h"
#include "apps/viewer/subjects_panel.h"
#include "apps/viewer/timeline_panel.h"
#include "apps/viewer/timings_panel.h"

namespace dpl {
namespace {

constexpr float kLeftWidth = 292, kRightWidth = 268;

/** Opens a panel at a corner that grows with its content as far as the window allows. */
void beginPanel(const char* title, float x, float y, float width, float mostHeight) {
    ImGui::SetNextWindowPos({x, y}, ImGuiCond_Always);
    ImGui::SetNextWindowSizeConstraints({width, 0}, {width, std::max(60.0f, mostHeight)});
    ImGui::Begin(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
    ImGui::PushItemWidth(-1);
}

/** Returns the height of the panel. */
float endPanel() {
    ImGui::PopItemWidth();
    const float height = ImGui::GetWindowHeight();
    ImGui::End();
    return height;
}

/** Between the panels. */
FreeSpan betweenPanels(const ViewerState& state, float width) {
    constexpr float kLeft = kLeftWidth + kPanelGap, kRight = kRightWidth + kPanelGap;
    if (!state.panels || width < 2 * (kLeft + kRight)) return {0, width};
    return {kLeft, width - kRight};
}

}  // namespace

FreeSpan heldBackSpan(const ViewerState& state, float width) {
    constexpr float kLeastWidth = 400;  // of both
    const FreeSpan free = betweenPanels(state, width);
    if (state.compared) return {};
    const bool belowPanels = state.panels && free.left == 0;
    if (!state.run || state.run->heldBack.id == 0 || belowPanels || free.right - free.left < kLeastWidth) return {};
    return {free.left + kHeldBackMargin, 0.5f * (free.left + free.right) - kHeldBackMargin / 2};
}

FreeSpan freeSpan(const ViewerState& state, float width) {
    const FreeSpan free = betweenPanels(state, width), heldBack = heldBackSpan(state, width);
    return heldBack.left < heldBack.right ? FreeSpan{heldBack.right, free.right} : free;
}

void drawPanels(ViewerState& state, float width, float height) {
    float top = kPanelGap;
    const bool overBar = state.player() && !state.compared && freeSpan(state, width).left < kLeftWidth;
    const float bottom = height - kPanelGap - (overBar ? kTimelineHeight + kPanelGap : 0);
    if (state.compared) {
        beginPanel("Compare", kPanelGap, top, kLeftWidth, height - 2 * kPanelGap);
        drawComparison(state);
        top += endPanel() + kPanelGap;
    }
    if (state.starter) {
        beginPanel("New avatar", kPanelGap, top, kLeftWidth, height - 2 * kPanelGap);
        drawNewRun(state);
        top += endPanel() + kPanelGap;
    }
    if (state.run) {
        beginPanel(("Run: " + state.run->watch.name() + "###run").c_str(), kPanelGap, top, kLeftWidth, height - 2 * kPanelGap);
        const FreeSpan heldBack = heldBackSpan(state, width);
        drawRun(state, heldBack.left < heldBack.right);
        top += endPanel() + kPanelGap;
    }
    beginPanel("Avatars", kPanelGap, top, kLeftWidth, bottom - top);
    drawSubjects(state);
    endPanel();
    drawTimeline(state, width, height);
    if (width < kLeftWidth + kRightWidth + 3 * kPanelGap) return;  // no room for the second column
    const float x = width - kRightWidth - kPanelGap;
    beginPanel("Picture", x, kPanelGap, kRightWidth, height - 2 * kPanelGap);
    drawPictureChoices(state);
    const float used = endPanel();
    if (state.subjects.empty()) return;
    ImGui::SetNextWindowCollapsed(true, ImGuiCond_Once);
    beginPanel("Timings", x, used + 2 * kPanelGap, kRightWidth, height - used - 3 * kPanelGap);
    drawTimings(state);
    endPanel();
}

}  // namespace dpl
