// SPDX-License-Identifier: Apache-2.0
// OpenXR with its bindings to Vulkan and to Android, and declarations that older headers lack.
#pragma once

#include <vulkan/vulkan.h>

#ifdef __ANDROID__
#include <jni.h>
#define XR_USE_PLATFORM_ANDROID
#endif
#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#ifndef XR_EXT_local_floor
#define XR_EXT_local_floor 1
#define XR_EXT_LOCAL_FLOOR_EXTENSION_NAME "XR_EXT_local_floor"
constexpr XrReferenceSpaceType XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT = XrReferenceSpaceType(1000426000);
#endif

#ifndef XR_FB_body_tracking
#define XR_FB_body_tracking 1
#define XR_FB_BODY_TRACKING_EXTENSION_NAME "XR_FB_body_tracking"
XR_DEFINE_HANDLE(XrBodyTrackerFB)
constexpr uint32_t XR_BODY_JOINT_COUNT_FB = 70;
constexpr XrStructureType XR_TYPE_BODY_TRACKER_CREATE_INFO_FB = XrStructureType(1000076001);
constexpr XrStructureType XR_TYPE_BODY_JOINTS_LOCATE_INFO_FB = XrStructureType(1000076002);
constexpr XrStructureType XR_TYPE_SYSTEM_BODY_TRACKING_PROPERTIES_FB = XrStructureType(1000076004);
constexpr XrStructureType XR_TYPE_BODY_JOINT_LOCATIONS_FB = XrStructureType(1000076005);
constexpr XrStructureType XR_TYPE_BODY_SKELETON_FB = XrStructureType(1000076006);
enum XrBodyJointSetFB { XR_BODY_JOINT_SET_DEFAULT_FB = 0, XR_BODY_JOINT_SET_MAX_ENUM_FB = 0x7FFFFFFF };
struct XrSystemBodyTrackingPropertiesFB {
    XrStructureType type;
    void* next;
    XrBool32 supportsBodyTracking;
};
struct XrBodyTrackerCreateInfoFB {
    XrStructureType type;
    const void* next;
    XrBodyJointSetFB bodyJointSet;
};
struct XrBodyJointsLocateInfoFB {
    XrStructureType type;
    const void* next;
    XrSpace baseSpace;
    XrTime time;
};
struct XrBodyJointLocationFB {
    XrSpaceLocationFlags locationFlags;
    XrPosef pose;
};
struct XrBodyJointLocationsFB {
    XrStructureType type;
    void* next;
    XrBool32 isActive;
    float confidence;
    uint32_t jointCount;
    XrBodyJointLocationFB* jointLocations;
    uint32_t skeletonChangedCount;
    XrTime time;
};
struct XrBodySkeletonJointFB {
    int32_t joint;
    int32_t parentJoint;
    XrPosef pose;
};
struct XrBodySkeletonFB {
    XrStructureType type;
    void* next;
    uint32_t jointCount;
    XrBodySkeletonJointFB* joints;
};
using PFN_xrCreateBodyTrackerFB = XrResult(XRAPI_PTR*)(XrSession, const XrBodyTrackerCreateInfoFB*, XrBodyTrackerFB*);
using PFN_xrDestroyBodyTrackerFB = XrResult(XRAPI_PTR*)(XrBodyTrackerFB);
using PFN_xrLocateBodyJointsFB = XrResult(XRAPI_PTR*)(XrBodyTrackerFB, const XrBodyJointsLocateInfoFB*, XrBodyJointLocationsFB*);
using PFN_xrGetBodySkeletonFB = XrResult(XRAPI_PTR*)(XrBodyTrackerFB, XrBodySkeletonFB*);
#endif
