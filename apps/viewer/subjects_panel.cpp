// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/subjects_panel.h"

#include <imgui.h>

#include <algorithm>

#include "apps/viewer/dressing_panel.h"
#include "apps/viewer/export_panel.h"
#include "apps/viewer/face_panel.h"
#include "apps/viewer/open_panel.h"
#include "apps/viewer/overlay_panel.h"
#include "apps/viewer/panel_style.h"

namespace dpl {
namespace {

constexpr float kFarthestM = 5;       // that a subject is moved
constexpr size_t kRecentAtStart = 5;  // of what was opened lately

void subjectList(ViewerState& state) {
    if (state.subjects.empty()) {  // also while the first is loaded: nothing moves from under the cursor
        ImGui::TextWrapped("Drop an avatar (.glb) or splats (.ply, .spz, .glb) on the window, or a film of a person to make an avatar of.");
        ImGui::BeginDisabled(!state.atHand.empty() && !state.rendererName.empty());  // before there is a renderer it waits for it
        if (ImGui::Button("Load the sample", {-1, 0})) state.wantsSample = true;
        ImGui::EndDisabled();
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("An avatar that comes with Doppel; it is made the first time, in seconds");
        if (!state.settings.recent.empty()) quiet("Opened lately");
        drawRecent(state, kRecentAtStart);
    }
    for (size_t i = 0; i < state.subjects.size(); ++i) {
        const ViewedSubject& subject = state.subjects[i];
        ImGui::PushID(int(i));
        ImGui::Checkbox("##shown", &state.subjects[i].shown);
        if (ImGui::IsItemHovered()) ImGui::SetTooltip(subject.shown ? "Hide %s" : "Show %s", subject.file.c_str());
        ImGui::SameLine();
        const float crossWidth = ImGui::CalcTextSize("x").x + 2 * ImGui::GetStyle().FramePadding.x;
        const float rowWidth = ImGui::GetContentRegionAvail().x - crossWidth - ImGui::GetStyle().ItemSpacing.x;
        if (ImGui::Selectable(subject.file.c_str(), state.selected == i, 0, {rowWidth, 0})) state.selected = i;
        ImGui::SameLine();
        if (ImGui::SmallButton("x")) state.wantsRemoval = i;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("Remove %s", subject.file.c_str());
        ImGui::PopID();
    }
    if (const ViewedSubject* chosen = state.chosen())
        quiet(chosen->isAvatar() ? "%.0f splats, %.0f joints" : "%.0f splats", chosen->info.splatCount, double(chosen->joints.size()));
    const float half = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    if (ImGui::Button("Open ...", {half, 0})) state.wantsOpenWindow = true;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("The key O does it too");
    ImGui::SameLine();
    if (ImGui::Button("Export ...", {half, 0})) openExport(state);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Pictures, videos, splats and meshes; the key E does it too");
    if (!state.atHand.empty()) ImGui::TextWrapped("Loading %s ...", state.atHand.c_str());
}

void clipControls(ViewerState& state, ViewedSubject& subject) {
    const char* shown = subject.clip ? subject.clips[*subject.clip].name.c_str() : "rest pose";
    if (ImGui::BeginCombo("##clip", shown)) {
        if (ImGui::Selectable("rest pose", !subject.clip)) state.wantsClip.emplace(std::nullopt);
        for (uint32_t i = 0; i < subject.clips.size(); ++i) {
            ImGui::PushID(int(i));
            if (ImGui::Selectable(subject.clips[i].name.c_str(), subject.clip == i)) state.wantsClip.emplace(i);
            ImGui::PopID();
        }
        ImGui::EndCombo();
    }
    if (!subject.clip) {
        if (subject.clips.empty()) quiet("Drop a motion (.bvh, .glb) to add a clip.");
        return;
    }
    ImGui::SliderFloat("##stiffness", &subject.clothStiffness, 0, 10, "cloth stiffness %.1f", ImGuiSliderFlags_AlwaysClamp);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("1: clothes move as learned; stiffer ones swing and lag less");
    if (ImGui::Button("Settle clothes", {-1, 0}))
        if (const auto settled = subject.avatar.settle(); !settled) state.messages.error(settled.error().message);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Clothes forget how the avatar moved until now");
}

void jointList(ViewedSubject& subject) {
    if (ImGui::Button("All as in the clip", {-1, 0})) std::fill(subject.byHandDeg.begin(), subject.byHandDeg.end(), Vec3f(0));
    ImGui::BeginChild("joints", {0, std::min(240.0f, 52.0f * float(subject.joints.size()))});
    ImGui::PushItemWidth(-1);
    for (size_t region = 0; region < kBodyRegions; ++region) {
        const auto here = [&](size_t joint) { return size_t(subject.regions[joint]) == region; };
        bool any = false;
        for (size_t i = 0; i < subject.joints.size() && !any; ++i) any = here(i);
        if (!any || !ImGui::TreeNodeEx(nameOf(BodyRegion(region)), ImGuiTreeNodeFlags_SpanAvailWidth)) continue;
        for (size_t i = 0; i < subject.joints.size(); ++i) {
            if (!here(i)) continue;
            ImGui::PushID(int(i));
            ImGui::TextUnformatted(subject.joints[i].c_str());
            ImGui::SliderFloat3("##angles", &subject.byHandDeg[i].x, -180, 180, "%.0f°");
            ImGui::PopID();
        }
        ImGui::TreePop();
    }
    ImGui::PopItemWidth();
    ImGui::EndChild();
}

}  // namespace

void drawSubjects(ViewerState& state) {
    subjectList(state);
    if (ViewedSubject* subject = state.chosen(); subject) {
        ImGui::SliderFloat("##turned", &subject->turnedDeg, -180, 180, "turned by %.0f°", ImGuiSliderFlags_AlwaysClamp);
        ImGui::PushItemWidth((ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2);
        for (int axis = 0; axis < 2; ++axis) {
            if (axis == 1) ImGui::SameLine();
            ImGui::PushID(axis);
            ImGui::DragFloat("##moved", &subject->movedM[axis], 0.01f, -kFarthestM, kFarthestM, axis == 0 ? "right %.2f m" : "front %.2f m",
                             ImGuiSliderFlags_AlwaysClamp);
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("Moved by hand: drag sideways, or double click to type");
            if (ImGui::IsItemDeactivatedAfterEdit()) state.wantsRoom = true;
            ImGui::PopID();
        }
        ImGui::PopItemWidth();
    }
    if (ViewedSubject* subject = state.chosen(); subject && subject->isAvatar()) {
        if (subject->comparable && !state.compared) {
            if (ImGui::Button("Compare with its pictures", {-1, 0})) state.wantsCompare = true;
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("The photographs of its scan over or beside it, and what differs");
        }
        if (ImGui::CollapsingHeader("Clip", ImGuiTreeNodeFlags_DefaultOpen)) clipControls(state, *subject);
        if (ImGui::CollapsingHeader("Joints by hand")) jointList(*subject);
        drawFace(state);
        drawOverlayChoice(state);
        drawDressing(state);
    }
}

}  // namespace dpl
