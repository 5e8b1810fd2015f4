// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/timeline_panel.h"

#include <imgui.h>

#include <algorithm>

#include "apps/viewer/panel_style.h"
#include "apps/viewer/panels.h"

namespace dpl {
namespace {

constexpr float kWidestTimeline = 760;

}  // namespace

void drawTimeline(ViewerState& state, float width, float height) {
    const ViewedSubject* player = state.player();
    if (!player || state.compared) return;
    const FreeSpan free = freeSpan(state, width);
    const float wide = std::min(kWidestTimeline, free.right - free.left - 2 * kPanelGap);
    ImGui::SetNextWindowPos({0.5f * (free.left + free.right), height - kPanelGap}, ImGuiCond_Always, {0.5f, 1});
    ImGui::SetNextWindowSize({wide, 0}, ImGuiCond_Always);
    ImGui::Begin("##timeline", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoScrollbar);
    Playback& clock = state.playback;
    const double durationS = player->clips[*player->clip].durationS;
    if (ImGui::Button(clock.playing ? "Pause" : "Play", {64, 0})) {
        clock.playing = !clock.playing;
        if (clock.playing && !clock.loop && clock.timeS >= durationS) clock.timeS = 0;
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("The space bar does it too");
    ImGui::SameLine();
    ImGui::PushItemWidth(std::max(40.0f, ImGui::GetContentRegionAvail().x - 172));
    float timeS = float(timeInClip(clock.timeS, durationS, clock.loop));
    if (ImGui::SliderFloat("##time", &timeS, 0, float(durationS), "%.2f s")) clock.timeS = timeS, clock.playing = false;
    ImGui::PopItemWidth();
    ImGui::SameLine();
    ImGui::Checkbox("loop", &clock.loop);
    ImGui::SameLine();
    ImGui::PushItemWidth(-1);
    float speed = float(clock.speed);
    if (ImGui::DragFloat("##speed", &speed, 0.01f, -2, 2, "%.2f x", ImGuiSliderFlags_AlwaysClamp)) clock.speed = speed;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Speed: drag sideways, or double click to type; below 0 it plays backwards");
    ImGui::PopItemWidth();
    ImGui::End();
}

}  // namespace dpl
