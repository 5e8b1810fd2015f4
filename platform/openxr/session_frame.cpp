// SPDX-License-Identifier: Apache-2.0
// A frame of a session: wait, begin, locate, draw, end.
#include <doppel/doppel_convert.h>

#include <algorithm>
#include <limits>

#include "platform/openxr/session_self.h"
#include "platform/openxr/views.h"

namespace dpl::xr {
namespace {

constexpr int kMaxTimeoutsInARow = 8;

}  // namespace

Result<Step> Session::Self::runFrame(Scene& scene) {
    XrFrameWaitInfo wait{XR_TYPE_FRAME_WAIT_INFO};
    XrFrameState state{XR_TYPE_FRAME_STATE};
    DPL_XR(xrWaitFrame, live_->session.handle, &wait, &state);
    XrFrameBeginInfo begin{XR_TYPE_FRAME_BEGIN_INFO};
    DPL_XR(xrBeginFrame, live_->session.handle, &begin);
    const Result<bool> drawn = state.shouldRender ? draw(scene, state) : Result<bool>(false);
    if (calls_.sessionLost) return Step::Lost;
    // A frame that was begun is ended, also when drawing failed.
    const Status ended = endFrame(state, drawn && *drawn);
    if (!drawn) return drawn.error();
    if (!ended) return ended.error();
    return *drawn ? Step::Drew : Step::Hidden;
}

/** False: nothing can be shown this time. */
Result<bool> Session::Self::draw(Scene& scene, const XrFrameState& state) {
    const Display& display = live_->display;
    if (Status synced = actions_.sync(calls_, live_->world.space(), state.predictedDisplayTime, controllers_); !synced)
        complain("the runtime does not tell where the controllers are");
    if (Status located = live_->hands.locate(calls_, live_->world.space(), state.predictedDisplayTime, frame_.user.hands); !located)
        complain("the runtime does not tell where the hands are");
    if (Status located = live_->body.locate(calls_, live_->world.space(), state.predictedDisplayTime, frame_.user.body); !located)
        complain("the runtime does not tell where the body is");
    moved_ = live_->world.takeMove(state.predictedDisplayTime);
    const auto hindrance = locateViews(calls_, live_->session.handle, display, live_->world.space(), state.predictedDisplayTime, views_);
    if (!hindrance) return hindrance.error();
    if (*hindrance) {
        complain(*hindrance);
        return false;
    }
    const auto acquired = live_->images.acquire(calls_);
    if (!acquired) return acquired.error();
    if (!*acquired) {
        complain("the runtime did not give an image back within 1 s");
        if (++timeoutsInARow_ >= kMaxTimeoutsInARow)
            return Error{DPL_ERROR_DEVICE, "the runtime has given no image back for several seconds; start it again"};
        return false;
    }
    timeoutsInARow_ = 0;
    DPL_XR_OK(describe(state));
    if (wantsCapture_ && options_.capture) DPL_XR_OK(capture_.begin(live_->images.shown()));
    DPL_XR_OK(commands_.begin(frame_));
    DPL_XR_OK(scene.draw(frame_));
    const bool capturing = wantsCapture_ && options_.capture;
    if (capturing) capture_.record(frame_.commands, live_->images);
    live_->images.giveDepthBack(frame_.commands);
    DPL_XR_OK(commands_.submit());
    ++drawnFrames_;
    if (capturing) {
        DPL_XR_OK(commands_.waitForAll());
        DPL_XR_OK(capture_.read(live_->images.shown(), options_.nearM, captured_));
        for (size_t i = 0; i < captured_.size(); ++i)
            captured_[i].camera = cameras_[i], captured_[i].pose = views_[i].pose, captured_[i].fov = views_[i].fov;
        wantsCapture_ = false;
    }
    fillLayer();
    return true;
}

/** Times, cameras and images of the frame. */
Status Session::Self::describe(const XrFrameState& state) {
    const Display& display = live_->display;
    if (!firstTime_) firstTime_ = state.predictedDisplayTime;
    frame_.timeS = std::max(frame_.timeS, dplSecondsBetween(*firstTime_, state.predictedDisplayTime));
    frame_.periodS = state.predictedDisplayPeriod > 0 ? double(state.predictedDisplayPeriod) * 1e-9 : 0;
    frame_.number = drawnFrames_;
    frame_.user.head = headOf(views_, display.viewCount);
    frame_.groupCount = display.groupCount;
    cameraCount_ = 0;
    for (uint32_t g = 0; g < display.groupCount; ++g) {
        GroupFrame& group = frame_.groups[g];
        DPL_XR_OK(camerasOf(views_ + cameraCount_, live_->images.shown().groups[g], group));
        live_->images.describe(g, options_.nearM, group);
        for (uint32_t v = 0; v < group.views; ++v) cameras_[cameraCount_++] = group.cameras[v];
    }
    return {};
}

void Session::Self::fillLayer() {
    const bool depth = live_->images.hasDepthLayer();
    uint32_t i = 0;
    for (uint32_t g = 0; g < live_->display.groupCount; ++g)
        for (uint32_t v = 0; v < live_->display.viewsOf(g); ++v, ++i) {
            XrCompositionLayerProjectionView& view = layerViews_[i];
            view = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW};
            view.pose = views_[i].pose, view.fov = views_[i].fov;
            view.subImage = live_->images.colourLayer(g, v);
            if (!depth) continue;
            XrCompositionLayerDepthInfoKHR& info = layerDepths_[i];
            info = {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR};
            info.subImage = live_->images.depthLayer(g, v);
            info.minDepth = 0, info.maxDepth = 1;
            info.nearZ = std::numeric_limits<float>::infinity(), info.farZ = options_.nearM;  // reversed: where 0 and 1 are stored
            view.next = &info;
        }
}

Status Session::Self::endFrame(const XrFrameState& state, bool withPicture) {
    if (withPicture) DPL_XR_OK(live_->images.release(calls_));
    XrCompositionLayerProjection projection{XR_TYPE_COMPOSITION_LAYER_PROJECTION};
    projection.layerFlags = live_->images.shown().blend == Blend::Alpha ? XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT : 0;
    projection.space = live_->world.space();
    projection.viewCount = live_->display.viewCount;
    projection.views = layerViews_;
    const XrCompositionLayerBaseHeader* layers[2];
    uint32_t layerCount = 0;
    if (live_->passesThrough) layers[layerCount++] = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&live_->passthrough.layer());
    if (withPicture) layers[layerCount++] = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&projection);
    XrFrameEndInfo info{XR_TYPE_FRAME_END_INFO};
    info.displayTime = state.predictedDisplayTime;
    info.environmentBlendMode = live_->display.blendMode;
    info.layerCount = layerCount;
    info.layers = layers;
    DPL_XR(xrEndFrame, live_->session.handle, &info);
    return {};
}

}  // namespace dpl::xr
