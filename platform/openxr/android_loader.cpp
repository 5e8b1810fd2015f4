// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/android_loader.h"

namespace dpl::xr {

Status initialiseLoader(JavaVM* vm, jobject activity) {
    PFN_xrInitializeLoaderKHR initialise = nullptr;
    const XrResult found =
        xrGetInstanceProcAddr(XR_NULL_HANDLE, "xrInitializeLoaderKHR", reinterpret_cast<PFN_xrVoidFunction*>(&initialise));
    if (XR_FAILED(found) || !initialise) return Error{DPL_ERROR_UNSUPPORTED, "the OpenXR loader of this app is not one for Android"};
    XrLoaderInitInfoAndroidKHR info{XR_TYPE_LOADER_INIT_INFO_ANDROID_KHR};
    info.applicationVM = vm;
    info.applicationContext = activity;
    const XrResult done = initialise(reinterpret_cast<const XrLoaderInitInfoBaseHeaderKHR*>(&info));
    if (XR_FAILED(done)) return Error{DPL_ERROR_UNSUPPORTED, "the OpenXR loader does not start (" + std::to_string(int(done)) + ")"};
    return {};
}

XrInstanceCreateInfoAndroidKHR androidInstance(JavaVM* vm, jobject activity) {
    XrInstanceCreateInfoAndroidKHR info{XR_TYPE_INSTANCE_CREATE_INFO_ANDROID_KHR};
    info.applicationVM = vm;
    info.applicationActivity = activity;
    return info;
}

}  // namespace dpl::xr
