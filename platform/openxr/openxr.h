// SPDX-License-Identifier: Apache-2.0
// OpenXR with its bindings to Vulkan and to Android, and declarations that headers older than 1.1 lack.
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
