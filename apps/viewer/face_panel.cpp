// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/face_panel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

#include "apps/viewer/panel_style.h"

namespace dpl {
namespace {

constexpr float kRowHeight = 27, kMostHeight = 300;

void slidersOf(FaceByHand& face, const std::vector<const FaceSlider*>& found) {
    for (const FaceSlider* slider : found) {
        float weight = face.weight(*slider);
        ImGui::PushID(slider->names.c_str());
        if (ImGui::SliderFloat("##weight", &weight, 0, 1, (slider->words + " %.2f").c_str(), ImGuiSliderFlags_AlwaysClamp))
            face.set(*slider, weight);
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", slider->names.c_str());
        ImGui::PopID();
    }
}

}  // namespace

void drawFace(ViewerState& state) {
    ViewedSubject* subject = state.chosen();
    if (!subject || !subject->face.any()) return;
    if (!ImGui::CollapsingHeader("Face")) return;
    FaceByHand& face = subject->face;
    ImGui::BeginDisabled(face.isNeutral());
    if (ImGui::Button("Neutral face", {-1, 0})) face.weights.fill(0);
    ImGui::EndDisabled();
    ImGui::Checkbox("blinks and looks around", &face.idles);
    ImGui::InputTextWithHint("##find", "find, such as smile", &state.faceSearch);
    ImGui::Checkbox("left and right together", &face.together);
    const auto found = face.sliders(state.faceSearch);
    if (found.empty()) return quiet("The face has nothing of this name.");
    const bool searched = !state.faceSearch.empty();  // then all that was found is open
    ImGui::BeginChild("face", {0, std::min(kMostHeight, kRowHeight * float(found.size() + kFaceRegions))});
    ImGui::PushItemWidth(-1);
    for (size_t region = 0; region < kFaceRegions; ++region) {
        std::vector<const FaceSlider*> here;
        std::copy_if(found.begin(), found.end(), std::back_inserter(here),
                     [&](const FaceSlider* slider) { return size_t(slider->region) == region; });
        if (here.empty()) continue;
        if (searched) ImGui::SetNextItemOpen(true);
        if (!ImGui::TreeNodeEx(nameOf(FaceRegion(region)), ImGuiTreeNodeFlags_SpanAvailWidth)) continue;
        slidersOf(face, here);
        ImGui::TreePop();
    }
    ImGui::PopItemWidth();
    ImGui::EndChild();
}

}  // namespace dpl
