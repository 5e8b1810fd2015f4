// SPDX-License-Identifier: Apache-2.0
// The state of the mock runtime, shared by its entry points. Everything is guarded by one mutex, which guard() holds during each call.
#pragma once

#define XR_USE_GRAPHICS_API_VULKAN
#include <vulkan/vulkan.h>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tests/xr/mock_runtime/control.h"
#include "tests/xr/mock_runtime/vulkan_calls.h"

namespace dpl::mockxr {

constexpr XrSystemId kSystem = 7;
constexpr const char* kLocalFloorExtension = "XR_EXT_local_floor";  // younger than some headers
constexpr auto kLocalFloor = XrReferenceSpaceType(1000426000);
constexpr XrPosef kLocalAtStart{{0, 0, 0, 1}, {0, 1.6f, 0}};
constexpr XrTime kFirstTime = 1'000'000'000;

struct Instance {
    std::set<std::string> extensions;
    bool lost = false, requirementsAsked = false;
    PFN_vkGetInstanceProcAddr vulkanProc = nullptr;
    VkInstance vulkanInstance = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    std::vector<uint32_t> queueFamilies;                                           // that the device has
    std::vector<std::string> paths;                                                // XrPath n is paths[n - 1]
    std::map<XrAction, std::map<std::string, std::vector<std::string>>> bindings;  // by interaction profile
};

struct Session {
    bool lost = false, running = false, exitRequested = false, attached = false;
    XrSessionState told = XR_SESSION_STATE_UNKNOWN;  // the last state that the caller has polled
    XrViewConfigurationType configuration = XR_VIEW_CONFIGURATION_TYPE_MAX_ENUM;
    bool waited = false, begun = false, firstFrameEnded = false;
    std::set<XrTime> predicted;  // display times of frames not ended yet
    std::vector<XrActionSet> attachedSets;
    bool synced = false;
    VulkanCalls vulkan;
};

struct Space {
    XrSession session = XR_NULL_HANDLE;
    XrReferenceSpaceType type = XR_REFERENCE_SPACE_TYPE_MAX_ENUM;
    XrAction action = XR_NULL_HANDLE;  // of an action space
    int hand = 0;
    XrPosef offset{};
};

struct Swapchain {
    XrSession session = XR_NULL_HANDLE;
    XrSwapchainCreateInfo info{};
    uint32_t number = 0;
    std::vector<VkImage> images;
    std::vector<VkDeviceMemory> memories;
    std::deque<uint32_t> acquired;
    bool waited = false;
    uint32_t next = 0;
    std::optional<uint32_t> released;
    uint64_t releasedInFrame = 0;
};

struct ActionSet {
    std::string name;
    bool attached = false;
};

struct Action {
    XrActionSet set = XR_NULL_HANDLE;
    std::string name;
    XrActionType type = XR_ACTION_TYPE_MAX_ENUM;
    std::vector<XrPath> subactions;
};

struct HandTracker {
    XrSession session = XR_NULL_HANDLE;
    int hand = 0;
};

/** Objects of extensions, which only have to be alive. */
struct Child {
    XrSession session = XR_NULL_HANDLE;
};

struct Runtime {
    std::recursive_mutex mutex;
    Settings settings;
    std::vector<Failure> failures;
    std::map<std::string, uint64_t> calls;
    std::vector<std::string> violations;
    const char* function = "";  // that runs now

    std::optional<Instance> instance;
    XrInstance instanceHandle = XR_NULL_HANDLE;
    std::map<XrSession, Session> sessions;
    std::map<XrSpace, Space> spaces;
    std::map<XrSwapchain, Swapchain> swapchains;
    std::map<XrActionSet, ActionSet> actionSets;
    std::map<XrAction, Action> actions;
    std::map<XrHandTrackerEXT, HandTracker> handTrackers;
    std::map<XrBodyTrackerFB, Child> bodyTrackers;
    std::map<XrPassthroughFB, Child> passthroughs;
    std::map<XrPassthroughLayerFB, Child> passthroughLayers;
    uintptr_t handles = 0x1000;  // no number is used twice, so that a stale handle is noticed

    std::deque<XrEventDataBuffer> events;
    FrameCounts counts;
    XrTime displayTime = kFirstTime;  // of the last frame that was waited for
    SubmittedFrame submitted;
    XrSessionState told = XR_SESSION_STATE_UNKNOWN;
    float refreshHz = 72;
    XrPosef worldFromLocal = kLocalAtStart;
    std::optional<XrPosef> nextWorldFromLocal;
    XrTime localChangesAt = 0;
    uint32_t swapchainsMade = 0;
    std::vector<std::string> vulkanMessages;
    bool vulkanValidated = false;

    template <class Handle>
    Handle newHandle() {
        return reinterpret_cast<Handle>(++handles);
    }
    XrDuration periodNs() const { return XrDuration(1e9 / double(refreshHz)); }
    bool enabled(const char* extension) const { return instance && instance->extensions.count(extension) > 0; }
    template <class Event>
    void send(const Event& event) {
        static_assert(sizeof(Event) <= sizeof(XrEventDataBuffer));
        XrEventDataBuffer buffer{};
        new (&buffer) Event(event);
        events.push_back(buffer);
    }
    void sendState(XrSession session, XrSessionState state);
};

Runtime& runtime();

/** Frees what the caller left behind: destroying a parent destroys its children. */
void destroySession(XrSession session);
void destroySwapchain(XrSwapchain swapchain);
void destroyInstance();

}  // namespace dpl::mockxr
