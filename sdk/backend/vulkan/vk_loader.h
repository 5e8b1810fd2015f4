// SPDX-License-Identifier: Apache-2.0
// Finds the machine's Vulkan loader while the program runs, so that a machine without it can still draw on the CPU.
#pragma once

#include "sdk/backend/vulkan/vk_functions.h"

namespace dpl::vk {

/** vkGetInstanceProcAddr of the Vulkan loader. The loader is never unloaded, because drivers may keep threads of their own.
 *  Code::Unsupported when no loader is installed; the text names the library. Any thread. */
Result<PFN_vkGetInstanceProcAddr> findVulkanLoader();

}  // namespace dpl::vk
