// SPDX-License-Identifier: Apache-2.0
// Switches of the Vulkan backend and of the renderer over it, for tests and benches. The product never sets them.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <string>

#include "sdk/backend/vulkan/vulkan_backend.h"

namespace dpl {

struct VulkanTestOptions : VulkanOptions {
    bool enableValidation = false;  // VK_LAYER_KHRONOS_validation with synchronisation checks; Code::NotFound when it is not installed
    std::string deviceName;         // part of the name of the wanted device; empty: the best device
    bool withoutMultiview = false;  // draw each view by itself, as on devices without multiview
    bool typedBuffers = true;       // false: kernels with plain buffers, even where a driver needs typed ones (vk_quirks.cpp)
    bool shuffle = true;            // false: kernels without subgroup shuffles, even if DeviceInfo::shuffle
    bool ignoreQuirks = false;      // do not apply the rows of vk_quirks.cpp
    std::span<const uint8_t> shaderPack;  // used instead of the SDK's shaders; copied
    uint64_t shaderInterface = 0;         // interface hash that the C++ code of shaderPack was compiled with
    /** Counts validation warnings and errors; their texts go to the log. */
    std::shared_ptr<std::atomic<uint32_t>> validationMessages;

    // Read by createVulkanRenderer (docs/adr/0027).
    bool preciseBlending = true;  // blend in 16-bit floats and round once; false: blend in 8 bits, which is below 50 dB close up
    bool cull = true;             // false: splats that face away, out of view or below 1/255 are drawn too (docs/reference/gate.md)
    bool shareViews = true;       // false: two views are two frames, always (docs/reference/gpu-frame.md)
    bool quantiseDepth = true;    // false: sort by 32-bit float depths instead of 16-bit keys (docs/reference/depth-keys.md)
};

/** As createVulkanBackend(VulkanOptions). */
Result<std::unique_ptr<Backend>> createVulkanBackend(const VulkanTestOptions& options);

}  // namespace dpl
