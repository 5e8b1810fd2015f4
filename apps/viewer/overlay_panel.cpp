// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/overlay_panel.h"

#include <imgui.h>

namespace dpl {
namespace {

constexpr ImU32 kUsual = IM_COL32(80, 200, 120, 230), kRare = IM_COL32(240, 200, 60, 230), kNever = IM_COL32(240, 70, 50, 230),
                kUnknown = IM_COL32(150, 155, 165, 160), kBounded = IM_COL32(240, 200, 60, 120), kTorn = IM_COL32(240, 50, 40, 190),
                kHidden = IM_COL32(90, 200, 255, 200);
constexpr float kNearM = 0.05f, kJointRadius = 5, kPointRadius = 1, kSecondColumn = 140;

}  // namespace

void drawOverlayChoice(ViewerState& state) {
    if (!ImGui::CollapsingHeader("What is weak")) return;
    for (const auto& [overlay, name, help] :
         {std::tuple(Overlay::None, "nothing", "The picture alone"),
          {Overlay::Needles, "stretched",
           "Yellow: triangles that the pose stretches or squeezes beyond what is drawn so; red: so much that they fade"},
          {Overlay::Trust, "pose", "Joints: green as in the film, yellow seldom there, red hardly ever, grey not known"},
          {Overlay::Hidden, "hidden", "Blue points: splats that are not drawn from here, because they show their other side alone"}}) {
        if (overlay == Overlay::Needles || overlay == Overlay::Hidden) ImGui::SameLine(kSecondColumn);
        if (ImGui::RadioButton(name, state.overlay == overlay)) state.overlay = overlay;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", help);
    }
    if (!state.weak.words.empty()) ImGui::TextWrapped("%s", state.weak.words.c_str());
}

void drawOverlay(const ViewerState& state, const Camerad& camera, float scale) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto seen = [&](const Vec3f& world, ImVec2& at) {
        const Vec3d view = camera.toView(Vec3d(world));
        if (view.z < kNearM) return false;
        const Vec2d px = camera.pixelOf(view);
        at = {float(px.x) / scale, float(px.y) / scale};
        return true;
    };
    for (const WeakTriangle& triangle : state.weak.triangles) {
        ImVec2 a, b, c;
        if (!seen(triangle.corners[0], a) || !seen(triangle.corners[1], b) || !seen(triangle.corners[2], c)) continue;
        const ImU32 colour = triangle.torn ? kTorn : kBounded;
        list.AddTriangleFilled(a, b, c, colour);
        if (triangle.torn) list.AddTriangle(a, b, c, colour);  // a needle has no width
    }
    for (const Vec3f& place : state.weak.hidden)
        if (ImVec2 at; seen(Vec3d(place), at))
            list.AddRectFilled({at.x - kPointRadius, at.y - kPointRadius}, {at.x + kPointRadius, at.y + kPointRadius}, kHidden);
    for (const JointTrust& joint : state.weak.joints) {
        ImVec2 at;
        if (!seen(joint.place, at)) continue;
        const ImU32 colour = joint.distance < 0 ? kUnknown : joint.distance <= 2 ? kUsual : joint.distance <= 4 ? kRare : kNever;
        list.AddCircleFilled(at, kJointRadius, colour);
    }
}

}  // namespace dpl
