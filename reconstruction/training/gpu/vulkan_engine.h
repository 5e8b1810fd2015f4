// SPDX-License-Identifier: Apache-2.0
// The engine on a Vulkan device.
#pragma once

#include "reconstruction/training/gpu/gpu_engine.h"
#include "sdk/backend/vulkan/vk_open.h"

namespace dpl {

/** On a device of its own. Unsupported: no Vulkan, no device that fits the request, or one that gives kernels too little. */
Result<std::unique_ptr<GpuEngine>> createVulkanEngine(const vk::DeviceRequest& request);

}  // namespace dpl
