// SPDX-License-Identifier: Apache-2.0
// Stands between Doppel and Vulkan: while it is idle, commands, submissions and fences of Doppel's go nowhere. What is left of a frame is
// the time of Doppel itself, so this is for benches.
//
//   DplVulkanDevice::getInstanceProcAddr = idleVulkan()
//
// The GPU then never tells that a slot has run: drop it before it is prepared again.
#pragma once

#include <vulkan/vulkan_core.h>

namespace dpl::test {

/** One device at a time. */
PFN_vkGetInstanceProcAddr idleVulkan();
void setVulkanIdle(bool idle);

}  // namespace dpl::test
