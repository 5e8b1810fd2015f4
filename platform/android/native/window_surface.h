// SPDX-License-Identifier: Apache-2.0
// How a window of the platform becomes a Vulkan surface. android_platform.cpp does it on Android; tests/android has a body for a desktop.
#pragma once

#include <vulkan/vulkan_core.h>

#include <doppel/doppel.hpp>
#include <memory>
#include <vector>

struct ANativeWindow;

namespace dpl::android {

using Window = std::shared_ptr<ANativeWindow>;

/** Instance extensions that makeSurface needs. */
std::vector<const char*> surfaceExtensions();
doppel::Result<VkSurfaceKHR> makeSurface(VkInstance instance, ANativeWindow* window);

}  // namespace dpl::android
