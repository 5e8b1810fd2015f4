// SPDX-License-Identifier: Apache-2.0
// What a test tells the mock runtime and asks it. A test links this library; the OpenXR loader opens the same file as the runtime
// (XR_RUNTIME_JSON), so both share one state. All functions may be called between any two xr calls, from any thread.
//
// Time is virtual: frame n is displayed at 1 s + n periods, and no call sleeps. The world is the stage: metres, +Y up. Every rule of the
// specification that the caller breaks is kept as a sentence in violations(), and the call returns the error that the specification gives.
#pragma once

#include "platform/openxr/openxr.h"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dpl::mockxr {

struct ViewSetting {
    XrPosef headFromView;
    XrFovf fov;
};

struct HandSetting {
    bool held = false;  // a controller is on and tracked
    XrPosef worldFromGrip{{0, 0, 0, 1}, {0, 0, 0}};
    XrPosef worldFromAim{{0, 0, 0, 1}, {0, 0, 0}};
    std::map<std::string, XrVector2f> inputs;  // by the end of a binding's path, such as "input/select/click"; one number: x
    /** By XR_EXT_hand_tracking, in the world. Empty: the hand is not seen. Else 26 joints, given out as they are, wrong ones too, except
     * that valid poses are moved to the space that the caller asks for. */
    std::vector<XrHandJointLocationEXT> joints;
};

struct Settings {
    Settings();

    XrViewConfigurationType viewConfiguration = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    std::vector<ViewSetting> views;  // of that configuration. Default: two eyes 64 mm apart, each wider on its outer side
    uint32_t widthPx = 64, heightPx = 64, maxSidePx = 4096;
    std::vector<int64_t> formats;  // of swapchains, best first
    std::vector<XrEnvironmentBlendMode> blendModes{XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    std::vector<std::string> extensions;  // offered. Default: all that the mock knows, except for other view configurations
    std::vector<XrReferenceSpaceType> referenceSpaces{XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL,
                                                      XR_REFERENCE_SPACE_TYPE_STAGE};
    std::vector<float> refreshRatesHz{72, 90};
    uint32_t swapchainImages = 3;
    bool hasSystem = true;
    bool tracksHands = true;           // as the system's properties say
    bool tracksBodies = true;          // the same
    bool automaticStates = true;       // the runtime moves the session through its states by itself
    std::optional<bool> shouldRender;  // empty: as the session's state says
    bool capture = false;              // read the submitted pictures; afterwards their images are filled with other values
    bool validation = true;            // load the Vulkan validation layer into the caller's instance, if it is installed

    std::function<XrPosef(XrTime)> worldFromHead;                             // default: 1.6 m above the stage, looking along -z
    std::function<void(XrTime, XrViewState&, std::span<XrView>)> spoilViews;  // changes what xrLocateViews returns
    std::function<void(bool enters)> onCall;                                  // when a call enters the mock and when it leaves
    HandSetting hands[2];                                                     // left, right
    /** By XR_FB_body_tracking, in the world. Empty: the body is not seen. Else 70 joints, given out as those of hands. */
    std::vector<XrBodyJointLocationFB> body;
    std::vector<XrBodySkeletonJointFB> skeleton;  // 70 joints in any order; wrong ones are given out too
    uint32_t skeletonChanges = 0;                 // count it up with each new skeleton
    std::string interactionProfile;               // empty: no controller is bound
};

/** An entry point that fails. nth: which of its calls, from 1. The function has no other effect, except that what it destroys is gone.
 * XR_ERROR_SESSION_LOST and XR_ERROR_INSTANCE_LOST stay until the session or the instance is destroyed. */
struct Failure {
    std::string function;
    uint64_t nth = 1, times = 1;
    XrResult result = XR_ERROR_RUNTIME_FAILURE;
};

struct SubmittedView {
    XrPosef pose;
    XrFovf fov;
    XrRect2Di rect;
    uint32_t swapchain = 0, layer = 0;  // swapchain: a number that tells different ones apart
    int64_t format = 0;
    bool fresh = false;           // its image was released in this frame
    std::vector<uint8_t> pixels;  // of the rectangle, in the swapchain's format
    bool hasDepth = false;        // the view has XrCompositionLayerDepthInfoKHR
    std::vector<float> depth;     // stored depth of its rectangle
    float minDepth = 0, maxDepth = 0, nearZ = 0, farZ = 0;
};

struct SubmittedLayer {
    XrStructureType type = XR_TYPE_UNKNOWN;
    XrCompositionLayerFlags flags = 0;
    std::vector<SubmittedView> views;  // of a projection layer
};

struct SubmittedFrame {
    XrTime displayTime = 0;
    XrEnvironmentBlendMode blendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    std::vector<SubmittedLayer> layers;
};

struct FrameCounts {
    uint64_t waited = 0, begun = 0, ended = 0, discarded = 0;
};

/** Forgets all of the past: violations, counts, failures, frames. No instance may be alive. */
void reset(const Settings& settings);
/** For changes while a session runs. */
Settings& settings();

void fail(const Failure& failure);
/** Queues a change of the session's state, whatever the state is. */
void sendState(XrSessionState state);
void sendInstanceLossPending();
/** Moves the origin of the local space at the next frame, and sends the event. */
void recentre(const XrPosef& worldFromLocal);
/** The display changes its rate by itself. */
void changeRefreshRate(float hz);

std::vector<std::string> violations();
/** How often each entry point was called since reset. */
std::map<std::string, uint64_t> calls();
FrameCounts frameCounts();
XrSessionState lastState();  // that the caller has been told
bool sessionRunning();
float refreshRateHz();
SubmittedFrame lastFrame();
/** Handles that were created and not destroyed. */
size_t liveHandles();
/** What the validation layer said, and whether it was there. */
std::vector<std::string> vulkanMessages();
bool vulkanValidated();

}  // namespace dpl::mockxr
