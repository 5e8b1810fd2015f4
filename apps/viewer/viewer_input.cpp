// SPDX-License-Identifier: Apache-2.0
// What mouse and keys do. Buttons and sliders are those of the panels.
#include <imgui.h>

#include <algorithm>

#include "apps/viewer/compared_avatar.h"
#include "apps/viewer/export_panel.h"
#include "apps/viewer/viewer.h"

namespace dpl {
namespace {

constexpr int kF1 = 290, kRight = 262, kLeft = 263, kEscape = 256;  // GLFW's codes

}  // namespace

void Viewer::takeInput() {
    const ImGuiIO& io = ImGui::GetIO();
    if (options_.isScript()) return;
    for (const int key : shell_->takeKeys()) takeKey(key);
    if (io.WantCaptureMouse || io.DisplaySize.y <= 0) return;
    if (state_.compared) return dragWipe();
    const auto drags = [&io](int button) {  // ImGui may tell of the last movement and of the release in one frame
        return (io.MouseDown[button] || io.MouseReleased[button]) && !io.MouseDownOwned[button];
    };
    if (drags(0) && !io.KeyShift) state_.camera.orbit(io.MouseDelta.x, io.MouseDelta.y, io.DisplaySize.y);
    if (drags(1) || drags(2) || (drags(0) && io.KeyShift)) state_.camera.pan(io.MouseDelta.x, io.MouseDelta.y, io.DisplaySize.y);
    if (io.MouseWheel != 0) {
        const FreeSpan free = freeNow();
        state_.camera.zoom(io.MouseWheel, io.MousePos.x - 0.5 * (free.left + free.right), io.MousePos.y - 0.5 * io.DisplaySize.y,
                           io.DisplaySize.y);
    }
    if (io.MouseDoubleClicked[0]) focusOn(io.MousePos.x, io.MousePos.y);
}

/** Dragging moves the line between photograph and avatar. */
void Viewer::dragWipe() {
    const ImGuiIO& io = ImGui::GetIO();
    const ComparedPlaces places = placesOfComparison(state_, io.DisplaySize.x, io.DisplaySize.y);
    if (io.MouseDown[0] && !io.MouseDownOwned[0] && places.right > places.left)
        state_.compared->comparison.wipe = std::clamp((io.MousePos.x - places.left) / (places.right - places.left), 0.0f, 1.0f);
}

void Viewer::takeKey(int key) {  // GLFW's codes of letters and digits are those of ASCII
    if (key == ' ') state_.playback.playing = !state_.playback.playing;
    if (key == 'F') state_.wantsFrame = true;
    if (key == 'O') state_.wantsOpenWindow = true;
    if (key == 'L') state_.log = !state_.log;
    if (key == 'H') state_.panels = !state_.panels;
    if (key == 'E') openExport(state_);
    if (key == 'P') state_.wantsExport = ExportKind::Picture;
    if (key == '1') state_.wantsPart = SeenPart::Whole;
    if (key == '2') state_.wantsPart = SeenPart::Face;
    if (key == '3') {
        state_.wantsPart = rightHand_ ? SeenPart::RightHand : SeenPart::LeftHand;
        rightHand_ = !rightHand_;
    }
    if (key == kF1) state_.help = !state_.help;
    if (state_.compared && key == kLeft) state_.compared->comparison.step(-1);
    if (state_.compared && key == kRight) state_.compared->comparison.step(1);
    if (key == kEscape) escape();
}

/** Closes or ends what was begun last. */
void Viewer::escape() {
    if (state_.open)
        state_.open.reset();
    else if (state_.log)
        state_.log = false;
    else if (state_.exports.open)
        state_.exports.open = false;
    else if (state_.exports.running)
        state_.wantsExportEnd = true;
    else
        state_.wantsCompareEnd = true;
}

/** Turns around what is seen there from now on, and selects whose it is. x, y: in ImGui's coordinates. */
void Viewer::focusOn(float x, float y) {
    const ImVec2 scale = ImGui::GetIO().DisplayFramebufferScale;
    const auto place = placeAt(state_.subjects, cameraNow(), {x * scale.x, y * scale.y});
    if (!place) return;
    state_.selected = place->subject;
    state_.camera.lookCloserAt(place->point);
}

}  // namespace dpl
