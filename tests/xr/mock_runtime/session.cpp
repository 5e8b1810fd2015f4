// SPDX-License-Identifier: Apache-2.0
// The life of a session: IDLE, READY, begin, first frame, SYNCHRONIZED, VISIBLE, FOCUSED, and back.
#include <algorithm>

#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"

namespace dpl::mockxr {
namespace {

template <class Map>
void eraseOf(Map& map, XrSession session) {
    for (auto i = map.begin(); i != map.end();) i = i->second.session == session ? map.erase(i) : std::next(i);
}

}  // namespace

void Runtime::sendState(XrSession session, XrSessionState state) {
    XrEventDataSessionStateChanged event{XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED};
    event.session = session;
    event.state = state;
    event.time = displayTime;
    send(event);
}

void destroySwapchain(XrSwapchain handle) {
    Runtime& r = runtime();
    Swapchain& swapchain = r.swapchains.at(handle);
    VulkanCalls& vulkan = r.sessions.at(swapchain.session).vulkan;
    for (size_t i = 0; i < swapchain.images.size(); ++i) vulkan.destroyImage(swapchain.images[i], swapchain.memories[i]);
    r.swapchains.erase(handle);
}

void destroySession(XrSession session) {
    Runtime& r = runtime();
    std::vector<XrSwapchain> left;
    for (const auto& [handle, swapchain] : r.swapchains)
        if (swapchain.session == session) left.push_back(handle);
    for (const XrSwapchain swapchain : left) destroySwapchain(swapchain);
    eraseOf(r.spaces, session);
    eraseOf(r.handTrackers, session);
    eraseOf(r.bodyTrackers, session);
    eraseOf(r.passthroughs, session);
    eraseOf(r.passthroughLayers, session);
    r.sessions.at(session).vulkan.close();
    r.sessions.erase(session);
    std::erase_if(r.events, [&](const XrEventDataBuffer& e) { return e.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED; });
}

void destroyInstance() {
    Runtime& r = runtime();
    while (!r.sessions.empty()) destroySession(r.sessions.begin()->first);
    r.actions.clear();
    r.actionSets.clear();
    r.events.clear();
    r.instance.reset();
}

namespace entry {

DPL_MOCKXR_ENTRY(xrCreateSession)(XrInstance, const XrSessionCreateInfo* info, XrSession* session) {
    Runtime& r = runtime();
    Instance& i = *r.instance;
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_SESSION_CREATE_INFO, "createInfo", {XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR}));
    DPL_MOCKXR_TRY(checkSystem(info->systemId));
    const auto* binding = chained<XrGraphicsBindingVulkan2KHR>(info->next, XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR);
    if (!binding) return violated(XR_ERROR_GRAPHICS_DEVICE_INVALID, "createInfo has no Vulkan device");
    if (!i.requirementsAsked)
        return violated(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING, "xrGetVulkanGraphicsRequirements2KHR was not called before");
    if (binding->instance != i.vulkanInstance || binding->physicalDevice != i.physicalDevice || binding->device != i.device || !i.device)
        return violated(XR_ERROR_GRAPHICS_DEVICE_INVALID, "the device is not the one that xrCreateVulkanDeviceKHR made");
    if (std::find(i.queueFamilies.begin(), i.queueFamilies.end(), binding->queueFamilyIndex) == i.queueFamilies.end())
        return violated(XR_ERROR_GRAPHICS_DEVICE_INVALID, "the device has no queue of that family");
    if (!r.sessions.empty()) return violated(XR_ERROR_LIMIT_REACHED, "there is a session already");
    const XrSession handle = r.newHandle<XrSession>();
    if (!r.sessions[handle].vulkan.open(i.vulkanProc, i.vulkanInstance, i.physicalDevice, i.device, binding->queueFamilyIndex,
                                        binding->queueIndex)) {
        r.sessions.erase(handle);
        return XR_ERROR_RUNTIME_FAILURE;
    }
    *session = handle;
    if (r.settings.automaticStates) {
        r.sendState(handle, XR_SESSION_STATE_IDLE);
        r.sendState(handle, XR_SESSION_STATE_READY);
    }
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroySession)(XrSession session) {
    destroySession(session);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrBeginSession)(XrSession handle, const XrSessionBeginInfo* info) {
    Session& session = runtime().sessions.at(handle);
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_SESSION_BEGIN_INFO, "beginInfo"));
    if (session.running) return violated(XR_ERROR_SESSION_RUNNING, "the session runs already");
    if (session.told != XR_SESSION_STATE_READY) return violated(XR_ERROR_SESSION_NOT_READY, "the last state was not READY");
    DPL_MOCKXR_TRY(checkConfiguration(info->primaryViewConfigurationType));
    session.running = true;
    session.configuration = info->primaryViewConfigurationType;
    session.waited = session.begun = session.firstFrameEnded = false;
    session.predicted.clear();
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrEndSession)(XrSession handle) {
    Runtime& r = runtime();
    Session& session = r.sessions.at(handle);
    if (!session.running) return violated(XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    if (session.told != XR_SESSION_STATE_STOPPING) return violated(XR_ERROR_SESSION_NOT_STOPPING, "the last state was not STOPPING");
    session.running = false;
    if (r.settings.automaticStates) {
        r.sendState(handle, XR_SESSION_STATE_IDLE);
        r.sendState(handle, session.exitRequested ? XR_SESSION_STATE_EXITING : XR_SESSION_STATE_READY);
    }
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrRequestExitSession)(XrSession handle) {
    Runtime& r = runtime();
    Session& session = r.sessions.at(handle);
    if (!session.running) return violated(XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    session.exitRequested = true;
    if (r.settings.automaticStates)
        for (const XrSessionState state : {XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING})
            r.sendState(handle, state);
    return XR_SUCCESS;
}

}  // namespace entry
}  // namespace dpl::mockxr
