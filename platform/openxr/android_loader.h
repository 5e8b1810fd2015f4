// SPDX-License-Identifier: Apache-2.0
// What OpenXR needs of an Android app before it makes an instance: the loader must know the app, and the runtime too.
//
//   XrInstanceCreateInfoAndroidKHR app = dpl::xr::androidInstance(vm, activity);
//   dpl::xr::initialiseLoader(vm, activity);
//   auto runtime = dpl::xr::Runtime::create({.instanceExtensions = {XR_KHR_ANDROID_CREATE_INSTANCE_EXTENSION_NAME}, .instanceNext = &app});
#pragma once

#include <jni.h>

#include "platform/openxr/runtime.h"

namespace dpl::xr {

/** Once a process, before any other call of OpenXR. Both live as long as the activity. DPL_ERROR_UNSUPPORTED: the loader does not know
 *  Android, or refused. */
Status initialiseLoader(JavaVM* vm, jobject activity);

XrInstanceCreateInfoAndroidKHR androidInstance(JavaVM* vm, jobject activity);

}  // namespace dpl::xr
