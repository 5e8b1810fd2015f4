// SPDX-License-Identifier: Apache-2.0
// xrGetInstanceProcAddr, the guard around every entry point, and how the loader finds both.
#include "tests/xr/mock_runtime/entry_points.h"

#include <cstring>

#include "tests/xr/mock_runtime/check.h"

namespace dpl::mockxr {
namespace {

XrResult lossOf(bool sessionLost) {
    if (runtime().instance->lost) return XR_ERROR_INSTANCE_LOST;
    return sessionLost ? XR_ERROR_SESSION_LOST : XR_SUCCESS;
}

XrResult stale(const char* what) {
    return violated(XR_ERROR_HANDLE_INVALID, std::string("the ") + what + " is not alive");
}

/** The first argument: alive, and not lost. */
XrResult checkHandle(XrInstance instance) {
    const Runtime& r = runtime();
    return r.instance && instance == r.instanceHandle ? lossOf(false) : stale("instance");
}
XrResult checkHandle(XrSession session) {
    const auto found = runtime().sessions.find(session);
    return found == runtime().sessions.end() ? stale("session") : lossOf(found->second.lost);
}
template <class Map, class Handle>
XrResult checkChild(const Map& map, Handle handle, const char* what) {
    const auto found = map.find(handle);
    return found == map.end() ? stale(what) : checkHandle(found->second.session);
}
XrResult checkHandle(XrSpace space) {
    return checkChild(runtime().spaces, space, "space");
}
XrResult checkHandle(XrSwapchain swapchain) {
    return checkChild(runtime().swapchains, swapchain, "swapchain");
}
XrResult checkHandle(XrHandTrackerEXT tracker) {
    return checkChild(runtime().handTrackers, tracker, "hand tracker");
}
XrResult checkHandle(XrBodyTrackerFB tracker) {
    return checkChild(runtime().bodyTrackers, tracker, "body tracker");
}
XrResult checkHandle(XrPassthroughFB passthrough) {
    return checkChild(runtime().passthroughs, passthrough, "passthrough");
}
XrResult checkHandle(XrPassthroughLayerFB layer) {
    return checkChild(runtime().passthroughLayers, layer, "passthrough layer");
}
XrResult checkHandle(XrActionSet set) {
    return runtime().actionSets.count(set) ? lossOf(false) : stale("action set");
}
XrResult checkHandle(XrAction action) {
    return runtime().actions.count(action) ? lossOf(false) : stale("action");
}
template <class Other>
XrResult checkHandle(const Other&) {
    return XR_SUCCESS;  // calls before there is an instance
}

XrSession sessionOf(XrSession session) {
    return session;
}
template <class Handle>
XrSession sessionOf(Handle handle) {
    if constexpr (std::is_same_v<Handle, XrSwapchain>) return runtime().swapchains.at(handle).session;
    if constexpr (std::is_same_v<Handle, XrSpace>) return runtime().spaces.at(handle).session;
    if constexpr (std::is_same_v<Handle, XrHandTrackerEXT>) return runtime().handTrackers.at(handle).session;
    if constexpr (std::is_same_v<Handle, XrPassthroughFB>) return runtime().passthroughs.at(handle).session;
    if constexpr (std::is_same_v<Handle, XrPassthroughLayerFB>) return runtime().passthroughLayers.at(handle).session;
    return XR_NULL_HANDLE;
}

/** The result that the test has planned for this call. */
std::optional<XrResult> planned(const char* name) {
    const uint64_t call = runtime().calls[name];
    for (const Failure& failure : runtime().failures)
        if (failure.function == name && call >= failure.nth && call - failure.nth < failure.times) return failure.result;
    return std::nullopt;
}

/** Tells Settings::onCall of a call. */
class Watched {
public:
    Watched() { tell(true); }
    ~Watched() { tell(false); }
    Watched(const Watched&) = delete;
    Watched& operator=(const Watched&) = delete;

private:
    static void tell(bool enters) {
        if (runtime().settings.onCall) runtime().settings.onCall(enters);
    }
};

template <auto f>
struct Guard;
template <class First, class... Rest, XrResult(XRAPI_PTR* f)(First, Rest...)>
struct Guard<f> {
    static inline const char* name = "";
    static XRAPI_ATTR XrResult XRAPI_CALL call(First first, Rest... rest) {
        Runtime& r = runtime();
        const std::lock_guard lock(r.mutex);
        const Watched watched;
        r.function = name;
        ++r.calls[name];
        const bool destroys = std::strncmp(name, "xrDestroy", 9) == 0;
        const XrResult usable = checkHandle(first);
        const bool lost = usable == XR_ERROR_INSTANCE_LOST || usable == XR_ERROR_SESSION_LOST;
        if (XR_FAILED(usable) && !(destroys && lost)) return usable;
        const std::optional<XrResult> failure = planned(name);
        if (!failure) return f(first, rest...);
        if (*failure == XR_ERROR_SESSION_LOST) {
            if (const XrSession session = sessionOf(first)) r.sessions.at(session).lost = true;
        } else if (*failure == XR_ERROR_INSTANCE_LOST && r.instance) {
            r.instance->lost = true;
        }
        if (destroys) f(first, rest...);
        return *failure;
    }
};

struct EntryPoint {
    const char* name;
    const char* extension;  // that has it; null: the core
    PFN_xrVoidFunction function;
};

template <auto f>
EntryPoint guarded(const char* name, const char* extension = nullptr) {
    Guard<f>::name = name;
    return {name, extension, reinterpret_cast<PFN_xrVoidFunction>(Guard<f>::call)};
}

XRAPI_ATTR XrResult XRAPI_CALL getInstanceProcAddr(XrInstance instance, const char* name, PFN_xrVoidFunction* function);

const std::vector<EntryPoint>& entryPoints() {
#define DPL_MOCKXR_CORE(name) guarded<entry::name>(#name)
#define DPL_MOCKXR_OF(extension, name) guarded<entry::name>(#name, extension)
    static const std::vector<EntryPoint> all = {
        {"xrGetInstanceProcAddr", nullptr, reinterpret_cast<PFN_xrVoidFunction>(getInstanceProcAddr)},
        DPL_MOCKXR_CORE(xrEnumerateApiLayerProperties),
        DPL_MOCKXR_CORE(xrEnumerateInstanceExtensionProperties),
        DPL_MOCKXR_CORE(xrCreateInstance),
        DPL_MOCKXR_CORE(xrDestroyInstance),
        DPL_MOCKXR_CORE(xrGetInstanceProperties),
        DPL_MOCKXR_CORE(xrPollEvent),
        DPL_MOCKXR_CORE(xrResultToString),
        DPL_MOCKXR_CORE(xrStructureTypeToString),
        DPL_MOCKXR_CORE(xrStringToPath),
        DPL_MOCKXR_CORE(xrPathToString),
        DPL_MOCKXR_CORE(xrGetSystem),
        DPL_MOCKXR_CORE(xrGetSystemProperties),
        DPL_MOCKXR_CORE(xrEnumerateEnvironmentBlendModes),
        DPL_MOCKXR_CORE(xrEnumerateViewConfigurations),
        DPL_MOCKXR_CORE(xrGetViewConfigurationProperties),
        DPL_MOCKXR_CORE(xrEnumerateViewConfigurationViews),
        DPL_MOCKXR_CORE(xrCreateSession),
        DPL_MOCKXR_CORE(xrDestroySession),
        DPL_MOCKXR_CORE(xrBeginSession),
        DPL_MOCKXR_CORE(xrEndSession),
        DPL_MOCKXR_CORE(xrRequestExitSession),
        DPL_MOCKXR_CORE(xrWaitFrame),
        DPL_MOCKXR_CORE(xrBeginFrame),
        DPL_MOCKXR_CORE(xrEndFrame),
        DPL_MOCKXR_CORE(xrEnumerateReferenceSpaces),
        DPL_MOCKXR_CORE(xrCreateReferenceSpace),
        DPL_MOCKXR_CORE(xrGetReferenceSpaceBoundsRect),
        DPL_MOCKXR_CORE(xrCreateActionSpace),
        DPL_MOCKXR_CORE(xrDestroySpace),
        DPL_MOCKXR_CORE(xrLocateSpace),
        DPL_MOCKXR_CORE(xrLocateViews),
        DPL_MOCKXR_CORE(xrEnumerateSwapchainFormats),
        DPL_MOCKXR_CORE(xrCreateSwapchain),
        DPL_MOCKXR_CORE(xrDestroySwapchain),
        DPL_MOCKXR_CORE(xrEnumerateSwapchainImages),
        DPL_MOCKXR_CORE(xrAcquireSwapchainImage),
        DPL_MOCKXR_CORE(xrWaitSwapchainImage),
        DPL_MOCKXR_CORE(xrReleaseSwapchainImage),
        DPL_MOCKXR_CORE(xrCreateActionSet),
        DPL_MOCKXR_CORE(xrDestroyActionSet),
        DPL_MOCKXR_CORE(xrCreateAction),
        DPL_MOCKXR_CORE(xrDestroyAction),
        DPL_MOCKXR_CORE(xrSuggestInteractionProfileBindings),
        DPL_MOCKXR_CORE(xrAttachSessionActionSets),
        DPL_MOCKXR_CORE(xrSyncActions),
        DPL_MOCKXR_CORE(xrGetActionStateBoolean),
        DPL_MOCKXR_CORE(xrGetActionStateFloat),
        DPL_MOCKXR_CORE(xrGetActionStateVector2f),
        DPL_MOCKXR_CORE(xrGetActionStatePose),
        DPL_MOCKXR_CORE(xrGetCurrentInteractionProfile),
        DPL_MOCKXR_OF(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, xrGetVulkanGraphicsRequirements2KHR),
        DPL_MOCKXR_OF(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, xrCreateVulkanInstanceKHR),
        DPL_MOCKXR_OF(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, xrGetVulkanGraphicsDevice2KHR),
        DPL_MOCKXR_OF(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, xrCreateVulkanDeviceKHR),
        DPL_MOCKXR_OF(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, xrEnumerateDisplayRefreshRatesFB),
        DPL_MOCKXR_OF(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, xrGetDisplayRefreshRateFB),
        DPL_MOCKXR_OF(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, xrRequestDisplayRefreshRateFB),
        DPL_MOCKXR_OF(XR_EXT_HAND_TRACKING_EXTENSION_NAME, xrCreateHandTrackerEXT),
        DPL_MOCKXR_OF(XR_EXT_HAND_TRACKING_EXTENSION_NAME, xrDestroyHandTrackerEXT),
        DPL_MOCKXR_OF(XR_EXT_HAND_TRACKING_EXTENSION_NAME, xrLocateHandJointsEXT),
        DPL_MOCKXR_OF(XR_FB_BODY_TRACKING_EXTENSION_NAME, xrCreateBodyTrackerFB),
        DPL_MOCKXR_OF(XR_FB_BODY_TRACKING_EXTENSION_NAME, xrDestroyBodyTrackerFB),
        DPL_MOCKXR_OF(XR_FB_BODY_TRACKING_EXTENSION_NAME, xrLocateBodyJointsFB),
        DPL_MOCKXR_OF(XR_FB_BODY_TRACKING_EXTENSION_NAME, xrGetBodySkeletonFB),
        DPL_MOCKXR_OF(XR_FB_PASSTHROUGH_EXTENSION_NAME, xrCreatePassthroughFB),
        DPL_MOCKXR_OF(XR_FB_PASSTHROUGH_EXTENSION_NAME, xrDestroyPassthroughFB),
        DPL_MOCKXR_OF(XR_FB_PASSTHROUGH_EXTENSION_NAME, xrPassthroughStartFB),
        DPL_MOCKXR_OF(XR_FB_PASSTHROUGH_EXTENSION_NAME, xrCreatePassthroughLayerFB),
        DPL_MOCKXR_OF(XR_FB_PASSTHROUGH_EXTENSION_NAME, xrDestroyPassthroughLayerFB),
    };
#undef DPL_MOCKXR_CORE
#undef DPL_MOCKXR_OF
    return all;
}

XRAPI_ATTR XrResult XRAPI_CALL getInstanceProcAddr(XrInstance instance, const char* name, PFN_xrVoidFunction* function) {
    const std::lock_guard lock(runtime().mutex);
    *function = nullptr;
    for (const EntryPoint& entry : entryPoints())
        if (std::strcmp(entry.name, name) == 0 && (!entry.extension || runtime().enabled(entry.extension))) *function = entry.function;
    return *function ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace

// The loader's interface, version 1. Headers older than 1.0.26 lack it.
struct LoaderInfo {
    uint32_t structType, structVersion;
    size_t structSize;
    uint32_t minInterfaceVersion, maxInterfaceVersion;
    XrVersion minApiVersion, maxApiVersion;
};
struct RuntimeRequest {
    uint32_t structType, structVersion;
    size_t structSize;
    uint32_t runtimeInterfaceVersion;
    XrVersion runtimeApiVersion;
    PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};

}  // namespace dpl::mockxr

extern "C" __attribute__((visibility("default"))) XrResult xrNegotiateLoaderRuntimeInterface(const dpl::mockxr::LoaderInfo* loader,
                                                                                             dpl::mockxr::RuntimeRequest* request) {
    if (!loader || !request || loader->minInterfaceVersion > 1 || loader->maxInterfaceVersion < 1) return XR_ERROR_INITIALIZATION_FAILED;
    request->runtimeInterfaceVersion = 1;
    request->runtimeApiVersion = XR_MAKE_VERSION(1, 0, 20);
    request->getInstanceProcAddr = dpl::mockxr::getInstanceProcAddr;
    return XR_SUCCESS;
}
