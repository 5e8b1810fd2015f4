// SPDX-License-Identifier: Apache-2.0
// What a session is made of. session.cpp makes and loses it, session_frame.cpp draws its frames. Internal to this room.
#pragma once

#include "platform/openxr/actions.h"
#include "platform/openxr/body_tracking.h"
#include "platform/openxr/capture.h"
#include "platform/openxr/frame_commands.h"
#include "platform/openxr/hand_tracking.h"
#include "platform/openxr/images.h"
#include "platform/openxr/passthrough.h"
#include "platform/openxr/session.h"
#include "platform/openxr/world.h"

namespace dpl::xr {

struct SessionHandle {
    XrSession handle = XR_NULL_HANDLE;
    ~SessionHandle() {
        if (handle) xrDestroySession(handle);
    }
};

/** One session and what dies with it, from last to first. */
struct Live {
    explicit Live(const Runtime& runtime) : images(runtime), passthrough(runtime), hands(runtime), body(runtime) {}
    SessionHandle session;
    World world;
    Images images;
    Passthrough passthrough;
    HandTracking hands;
    BodyTracking body;
    Display display;
    bool passesThrough = false;
};

struct Session::Self {
    Self(Runtime& runtime, const SessionOptions& options)
        : runtime_(runtime), options_(options), calls_(runtime), commands_(runtime), actions_(runtime), capture_(runtime) {}

    Result<Step> step(Scene& scene);
    Result<bool> open(Scene& scene);
    Status startPassthrough(Live& live);
    Status pollEvents();
    Status stateChanged(XrSessionState state);
    Result<Step> runFrame(Scene& scene);
    Result<bool> draw(Scene& scene, const XrFrameState& state);
    Status describe(const XrFrameState& state);
    Status endFrame(const XrFrameState& state, bool withPicture);
    void fillLayer();
    Status close();
    void complain(const char* text) {
        if (complaint_ != text) complaint_ = text;
    }

    Runtime& runtime_;
    SessionOptions options_;
    Calls calls_;
    FrameCommands commands_;
    bool ready_ = false, hasActions_ = false;  // commands and actions were made; the runtime takes the actions
    Actions actions_;
    Capture capture_;
    std::unique_ptr<Live> live_;
    Scene* scene_ = nullptr;  // has heard begin() and not yet end()

    XrSessionState state_ = XR_SESSION_STATE_UNKNOWN;
    bool running_ = false, exiting_ = false, wantsExit_ = false, askedForExit_ = false, ended_ = false, wantsCapture_ = false;
    std::optional<Error> failed_;
    int lossesInARow_ = 0, timeoutsInARow_ = 0;
    std::string complaint_;
    float refreshHz_ = 0;

    Frame frame_;
    uint64_t drawnFrames_ = 0;
    std::optional<XrTime> firstTime_;
    XrView views_[kMaxViews]{};
    DplCamera cameras_[kMaxViews]{};
    uint32_t cameraCount_ = 0;
    XrCompositionLayerProjectionView layerViews_[kMaxViews]{};
    XrCompositionLayerDepthInfoKHR layerDepths_[kMaxViews]{};
    std::vector<CapturedView> captured_;
    Controllers controllers_;
    std::optional<XrPosef> moved_;
};

}  // namespace dpl::xr
