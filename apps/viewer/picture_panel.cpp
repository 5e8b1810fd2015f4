// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/picture_panel.h"

#include <imgui.h>

#include <algorithm>

#include "apps/shared/pictures.h"

namespace dpl {

void drawPictureChoices(ViewerState& state) {
    int room = !state.room ? 2 : *state.room == platform::RoomLight::Bright ? 1 : 0;
    bool changed = ImGui::RadioButton("dark", &room, 0);
    ImGui::SameLine();
    changed |= ImGui::RadioButton("bright", &room, 1);
    ImGui::SameLine();
    changed |= ImGui::RadioButton("no room", &room, 2);
    if (changed)
        state.settings.room = room == 2   ? "none"
                              : room == 1 ? "bright"
                                          : "dark",
        state.room = room == 2 ? std::nullopt : std::optional(room == 1 ? platform::RoomLight::Bright : platform::RoomLight::Dark);
    if (std::any_of(state.subjects.begin(), state.subjects.end(), [](const ViewedSubject& s) { return !s.isAvatar(); }))
        if (ImGui::BeginCombo("##axes", state.axes.empty() ? "files stand as they state" : ("files are " + state.axes).c_str())) {
            if (ImGui::Selectable("as they state", state.axes.empty())) state.axes.clear(), state.wantsFrame = true;
            for (const std::string& axes : kAxesNames)
                if (ImGui::Selectable(axes.c_str(), state.axes == axes)) state.axes = axes, state.wantsFrame = true;
            ImGui::EndCombo();
        }
    float lensDeg = glm::degrees(float(state.camera.fovYRad()));
    if (ImGui::SliderFloat("##lens", &lensDeg, glm::degrees(float(OrbitCamera::kLeastFovYRad)),
                           glm::degrees(float(OrbitCamera::kMostFovYRad)), "lens %.0f°", ImGuiSliderFlags_AlwaysClamp))
        state.camera.setFovY(glm::radians(double(lensDeg)));
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("Field of view: narrow as a portrait lens, wide as a phone's. The person keeps their size");
    const float half = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    if (ImGui::Button("Keys (F1)", {half, 0})) state.help = !state.help;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("What keys and mouse do");
    ImGui::SameLine();
    if (ImGui::Button("Log (L)", {-1, 0})) state.log = !state.log;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("All that was said until now");
    if (!ImGui::CollapsingHeader("For engineers")) return;
    ImGui::SliderFloat("##detail", &state.splatsPerPixel, 0, 24,
                       state.splatsPerPixel > 0 ? "detail %.1f splats a pixel" : "detail: all splats");
    ImGui::SliderFloat("##budget", &state.frameBudgetMs, 0, 50, state.frameBudgetMs > 0 ? "budget %.1f ms a frame" : "no frame budget");
    ImGui::SliderFloat("##magnification", &state.magnification, 0, 32,
                       state.magnification <= 0 ? "come as near as you like"
                       : state.keptAway         ? "details %.0f pixels wide: no nearer"
                                                : "details at most %.0f pixels wide");
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("How near the camera may come before it shows more than the scan has seen; 0: no limit");
}

}  // namespace dpl
