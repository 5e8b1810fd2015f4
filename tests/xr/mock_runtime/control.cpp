// SPDX-License-Identifier: Apache-2.0
#include "tests/xr/mock_runtime/control.h"

#include "tests/xr/mock_runtime/pose.h"
#include "tests/xr/mock_runtime/runtime.h"

namespace dpl::mockxr {
namespace {

/** Copies something of the runtime under its mutex. */
template <class Read>
auto read(Read get) {
    const std::lock_guard lock(runtime().mutex);
    return get(runtime());
}

}  // namespace

Runtime& runtime() {
    static Runtime instance;
    return instance;
}

Settings::Settings() {
    views = {{{{0, 0, 0, 1}, {-0.032f, 0, 0}}, {-0.80f, 0.70f, 0.75f, -0.85f}},
             {{{0, 0, 0, 1}, {0.032f, 0, 0}}, {-0.70f, 0.80f, 0.75f, -0.85f}}};
    formats = {VK_FORMAT_R8G8B8A8_SRGB,  VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT,
               VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_D32_SFLOAT,    VK_FORMAT_D24_UNORM_S8_UINT,
               VK_FORMAT_D16_UNORM};
    extensions = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME,
                  XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
                  XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME,
                  XR_FB_PASSTHROUGH_EXTENSION_NAME,
                  XR_EXT_HAND_TRACKING_EXTENSION_NAME,
                  XR_FB_BODY_TRACKING_EXTENSION_NAME,
                  kLocalFloorExtension};
    worldFromHead = [](XrTime) { return kLocalAtStart; };
}

void reset(const Settings& settings) {
    Runtime& r = runtime();
    const std::lock_guard lock(r.mutex);
    if (r.instance) destroyInstance();  // of a test that failed
    r.settings = settings;
    r.failures.clear();
    r.calls.clear();
    r.violations.clear();
    r.events.clear();
    r.counts = {};
    r.displayTime = kFirstTime;
    r.submitted = {};
    r.told = XR_SESSION_STATE_UNKNOWN;
    r.refreshHz = settings.refreshRatesHz.empty() ? 72 : settings.refreshRatesHz.front();
    r.worldFromLocal = kLocalAtStart;
    r.nextWorldFromLocal.reset();
    r.swapchainsMade = 0;
    r.vulkanMessages.clear();
}

Settings& settings() {
    return runtime().settings;
}

void fail(const Failure& failure) {
    read([&](Runtime& r) { r.failures.push_back(failure); });
}

void sendState(XrSessionState state) {
    read([&](Runtime& r) {
        if (!r.sessions.empty()) r.sendState(r.sessions.begin()->first, state);
    });
}

void sendInstanceLossPending() {
    read([](Runtime& r) {
        XrEventDataInstanceLossPending event{XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING};
        event.lossTime = r.displayTime + r.periodNs();
        r.send(event);
    });
}

void recentre(const XrPosef& worldFromLocal) {
    read([&](Runtime& r) {
        XrEventDataReferenceSpaceChangePending event{XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING};
        event.session = r.sessions.empty() ? XR_NULL_HANDLE : r.sessions.begin()->first;
        event.changeTime = r.localChangesAt = r.displayTime + r.periodNs();
        event.poseValid = XR_TRUE;
        event.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
        event.poseInPreviousSpace = compose(inverse(r.worldFromLocal), worldFromLocal);
        r.send(event);
        if (r.enabled(kLocalFloorExtension)) {
            event.referenceSpaceType = kLocalFloor;
            event.poseInPreviousSpace = compose(inverse(onFloor(r.worldFromLocal)), onFloor(worldFromLocal));
            r.send(event);
        }
        r.nextWorldFromLocal = worldFromLocal;
    });
}

void changeRefreshRate(float hz) {
    read([&](Runtime& r) {
        XrEventDataDisplayRefreshRateChangedFB event{XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB};
        event.fromDisplayRefreshRate = r.refreshHz;
        event.toDisplayRefreshRate = r.refreshHz = hz;
        r.send(event);
    });
}

std::vector<std::string> violations() {
    return read([](const Runtime& r) { return r.violations; });
}
std::map<std::string, uint64_t> calls() {
    return read([](const Runtime& r) { return r.calls; });
}
FrameCounts frameCounts() {
    return read([](const Runtime& r) { return r.counts; });
}
XrSessionState lastState() {
    return read([](const Runtime& r) { return r.told; });
}
bool sessionRunning() {
    return read([](const Runtime& r) { return !r.sessions.empty() && r.sessions.begin()->second.running; });
}
float refreshRateHz() {
    return read([](const Runtime& r) { return r.refreshHz; });
}
SubmittedFrame lastFrame() {
    return read([](const Runtime& r) { return r.submitted; });
}
size_t liveHandles() {
    return read([](const Runtime& r) {
        return size_t(r.instance.has_value()) + r.sessions.size() + r.spaces.size() + r.swapchains.size() + r.actionSets.size() +
               r.actions.size() + r.passthroughs.size() + r.passthroughLayers.size() + r.handTrackers.size() + r.bodyTrackers.size();
    });
}
std::vector<std::string> vulkanMessages() {
    return read([](const Runtime& r) { return r.vulkanMessages; });
}
bool vulkanValidated() {
    return runtime().vulkanValidated;
}

}  // namespace dpl::mockxr
