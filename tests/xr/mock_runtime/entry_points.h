// SPDX-License-Identifier: Apache-2.0
// The entry points of the mock, by subject. They are called through entry_points.cpp, which holds the mutex, counts, checks the first
// handle, and fails a call when the test asks for that.
#pragma once

#include "tests/xr/mock_runtime/runtime.h"

namespace dpl::mockxr::entry {

#define DPL_MOCKXR_ENTRY(name) XRAPI_ATTR XrResult XRAPI_CALL name

// instance.cpp
DPL_MOCKXR_ENTRY(xrEnumerateApiLayerProperties)(uint32_t, uint32_t*, XrApiLayerProperties*);
DPL_MOCKXR_ENTRY(xrEnumerateInstanceExtensionProperties)(const char*, uint32_t, uint32_t*, XrExtensionProperties*);
DPL_MOCKXR_ENTRY(xrCreateInstance)(const XrInstanceCreateInfo*, XrInstance*);
DPL_MOCKXR_ENTRY(xrDestroyInstance)(XrInstance);
DPL_MOCKXR_ENTRY(xrGetInstanceProperties)(XrInstance, XrInstanceProperties*);
DPL_MOCKXR_ENTRY(xrPollEvent)(XrInstance, XrEventDataBuffer*);
DPL_MOCKXR_ENTRY(xrResultToString)(XrInstance, XrResult, char*);
DPL_MOCKXR_ENTRY(xrStructureTypeToString)(XrInstance, XrStructureType, char*);
DPL_MOCKXR_ENTRY(xrStringToPath)(XrInstance, const char*, XrPath*);
DPL_MOCKXR_ENTRY(xrPathToString)(XrInstance, XrPath, uint32_t, uint32_t*, char*);

// system.cpp
DPL_MOCKXR_ENTRY(xrGetSystem)(XrInstance, const XrSystemGetInfo*, XrSystemId*);
DPL_MOCKXR_ENTRY(xrGetSystemProperties)(XrInstance, XrSystemId, XrSystemProperties*);
DPL_MOCKXR_ENTRY(xrEnumerateEnvironmentBlendModes)
(XrInstance, XrSystemId, XrViewConfigurationType, uint32_t, uint32_t*, XrEnvironmentBlendMode*);
DPL_MOCKXR_ENTRY(xrEnumerateViewConfigurations)(XrInstance, XrSystemId, uint32_t, uint32_t*, XrViewConfigurationType*);
DPL_MOCKXR_ENTRY(xrGetViewConfigurationProperties)(XrInstance, XrSystemId, XrViewConfigurationType, XrViewConfigurationProperties*);
DPL_MOCKXR_ENTRY(xrEnumerateViewConfigurationViews)
(XrInstance, XrSystemId, XrViewConfigurationType, uint32_t, uint32_t*, XrViewConfigurationView*);

// vulkan_binding.cpp
DPL_MOCKXR_ENTRY(xrGetVulkanGraphicsRequirements2KHR)(XrInstance, XrSystemId, XrGraphicsRequirementsVulkanKHR*);
DPL_MOCKXR_ENTRY(xrCreateVulkanInstanceKHR)(XrInstance, const XrVulkanInstanceCreateInfoKHR*, VkInstance*, VkResult*);
DPL_MOCKXR_ENTRY(xrGetVulkanGraphicsDevice2KHR)(XrInstance, const XrVulkanGraphicsDeviceGetInfoKHR*, VkPhysicalDevice*);
DPL_MOCKXR_ENTRY(xrCreateVulkanDeviceKHR)(XrInstance, const XrVulkanDeviceCreateInfoKHR*, VkDevice*, VkResult*);

// session.cpp
DPL_MOCKXR_ENTRY(xrCreateSession)(XrInstance, const XrSessionCreateInfo*, XrSession*);
DPL_MOCKXR_ENTRY(xrDestroySession)(XrSession);
DPL_MOCKXR_ENTRY(xrBeginSession)(XrSession, const XrSessionBeginInfo*);
DPL_MOCKXR_ENTRY(xrEndSession)(XrSession);
DPL_MOCKXR_ENTRY(xrRequestExitSession)(XrSession);

// frames.cpp
DPL_MOCKXR_ENTRY(xrWaitFrame)(XrSession, const XrFrameWaitInfo*, XrFrameState*);
DPL_MOCKXR_ENTRY(xrBeginFrame)(XrSession, const XrFrameBeginInfo*);
DPL_MOCKXR_ENTRY(xrEndFrame)(XrSession, const XrFrameEndInfo*);

// spaces.cpp
DPL_MOCKXR_ENTRY(xrEnumerateReferenceSpaces)(XrSession, uint32_t, uint32_t*, XrReferenceSpaceType*);
DPL_MOCKXR_ENTRY(xrCreateReferenceSpace)(XrSession, const XrReferenceSpaceCreateInfo*, XrSpace*);
DPL_MOCKXR_ENTRY(xrGetReferenceSpaceBoundsRect)(XrSession, XrReferenceSpaceType, XrExtent2Df*);
DPL_MOCKXR_ENTRY(xrCreateActionSpace)(XrSession, const XrActionSpaceCreateInfo*, XrSpace*);
DPL_MOCKXR_ENTRY(xrDestroySpace)(XrSpace);
DPL_MOCKXR_ENTRY(xrLocateSpace)(XrSpace, XrSpace, XrTime, XrSpaceLocation*);
DPL_MOCKXR_ENTRY(xrLocateBodyJointsFB)(XrBodyTrackerFB, const XrBodyJointsLocateInfoFB*, XrBodyJointLocationsFB*);
DPL_MOCKXR_ENTRY(xrLocateHandJointsEXT)(XrHandTrackerEXT, const XrHandJointsLocateInfoEXT*, XrHandJointLocationsEXT*);
DPL_MOCKXR_ENTRY(xrLocateViews)(XrSession, const XrViewLocateInfo*, XrViewState*, uint32_t, uint32_t*, XrView*);

// swapchains.cpp
DPL_MOCKXR_ENTRY(xrEnumerateSwapchainFormats)(XrSession, uint32_t, uint32_t*, int64_t*);
DPL_MOCKXR_ENTRY(xrCreateSwapchain)(XrSession, const XrSwapchainCreateInfo*, XrSwapchain*);
DPL_MOCKXR_ENTRY(xrDestroySwapchain)(XrSwapchain);
DPL_MOCKXR_ENTRY(xrEnumerateSwapchainImages)(XrSwapchain, uint32_t, uint32_t*, XrSwapchainImageBaseHeader*);
DPL_MOCKXR_ENTRY(xrAcquireSwapchainImage)(XrSwapchain, const XrSwapchainImageAcquireInfo*, uint32_t*);
DPL_MOCKXR_ENTRY(xrWaitSwapchainImage)(XrSwapchain, const XrSwapchainImageWaitInfo*);
DPL_MOCKXR_ENTRY(xrReleaseSwapchainImage)(XrSwapchain, const XrSwapchainImageReleaseInfo*);

// actions.cpp
DPL_MOCKXR_ENTRY(xrCreateActionSet)(XrInstance, const XrActionSetCreateInfo*, XrActionSet*);
DPL_MOCKXR_ENTRY(xrDestroyActionSet)(XrActionSet);
DPL_MOCKXR_ENTRY(xrCreateAction)(XrActionSet, const XrActionCreateInfo*, XrAction*);
DPL_MOCKXR_ENTRY(xrDestroyAction)(XrAction);
DPL_MOCKXR_ENTRY(xrSuggestInteractionProfileBindings)(XrInstance, const XrInteractionProfileSuggestedBinding*);
DPL_MOCKXR_ENTRY(xrAttachSessionActionSets)(XrSession, const XrSessionActionSetsAttachInfo*);
DPL_MOCKXR_ENTRY(xrSyncActions)(XrSession, const XrActionsSyncInfo*);
DPL_MOCKXR_ENTRY(xrGetActionStateBoolean)(XrSession, const XrActionStateGetInfo*, XrActionStateBoolean*);
DPL_MOCKXR_ENTRY(xrGetActionStateFloat)(XrSession, const XrActionStateGetInfo*, XrActionStateFloat*);
DPL_MOCKXR_ENTRY(xrGetActionStateVector2f)(XrSession, const XrActionStateGetInfo*, XrActionStateVector2f*);
DPL_MOCKXR_ENTRY(xrGetActionStatePose)(XrSession, const XrActionStateGetInfo*, XrActionStatePose*);
DPL_MOCKXR_ENTRY(xrGetCurrentInteractionProfile)(XrSession, XrPath, XrInteractionProfileState*);

// extensions.cpp
DPL_MOCKXR_ENTRY(xrEnumerateDisplayRefreshRatesFB)(XrSession, uint32_t, uint32_t*, float*);
DPL_MOCKXR_ENTRY(xrGetDisplayRefreshRateFB)(XrSession, float*);
DPL_MOCKXR_ENTRY(xrRequestDisplayRefreshRateFB)(XrSession, float);
DPL_MOCKXR_ENTRY(xrCreateHandTrackerEXT)(XrSession, const XrHandTrackerCreateInfoEXT*, XrHandTrackerEXT*);
DPL_MOCKXR_ENTRY(xrDestroyHandTrackerEXT)(XrHandTrackerEXT);
DPL_MOCKXR_ENTRY(xrCreateBodyTrackerFB)(XrSession, const XrBodyTrackerCreateInfoFB*, XrBodyTrackerFB*);
DPL_MOCKXR_ENTRY(xrDestroyBodyTrackerFB)(XrBodyTrackerFB);
DPL_MOCKXR_ENTRY(xrGetBodySkeletonFB)(XrBodyTrackerFB, XrBodySkeletonFB*);
DPL_MOCKXR_ENTRY(xrCreatePassthroughFB)(XrSession, const XrPassthroughCreateInfoFB*, XrPassthroughFB*);
DPL_MOCKXR_ENTRY(xrDestroyPassthroughFB)(XrPassthroughFB);
DPL_MOCKXR_ENTRY(xrPassthroughStartFB)(XrPassthroughFB);
DPL_MOCKXR_ENTRY(xrCreatePassthroughLayerFB)(XrSession, const XrPassthroughLayerCreateInfoFB*, XrPassthroughLayerFB*);
DPL_MOCKXR_ENTRY(xrDestroyPassthroughLayerFB)(XrPassthroughLayerFB);

}  // namespace dpl::mockxr::entry
