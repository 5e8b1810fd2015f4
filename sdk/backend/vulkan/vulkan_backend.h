// SPDX-License-Identifier: Apache-2.0
// Vulkan 1.1 behind backend.h. No Vulkan type leaves this folder.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sdk/backend/backend.h"

namespace dpl {

struct VulkanOptions {
    bool allowSoftwareDevice = false;  // lavapipe and its like
    bool enableValidation = false;     // VK_LAYER_KHRONOS_validation with synchronisation checks; an error when it is not installed
    std::string deviceName;            // part of the wanted device's name; empty: the best one
    bool withoutMultiview = false;     // a draw a view, as devices without it do
    bool preciseBlending =
        true;          // blend in 16 bits and round once; false: in 8 bits, faster, below 50 dB close up (docs/adr/0002-the-gpu-frame.md)
    bool cull = true;  // false: no tier of it, to measure what it saves: splats that are turned away or below 1/255 are sorted and drawn
                       // too, over the box of 3 σ of plain 3D Gaussian splatting, and add nothing there. The same picture, with quads byte
                       // for byte; tiles may stop a splat earlier or later
    bool shareViews = true;               // false: two views are two frames even where one order serves both, to measure what sharing saves
    bool quantiseDepth = true;            // false: sort by 32-bit float depths, to measure what 16 bits save and cost
    bool codes16 = true;                  // false: precise blending in halves even where DeviceInfo::codes16, as other devices do it
    bool typedBuffers = true;             // false: plain kernels even where DeviceInfo::texels, as other devices run them; the same bytes
    bool shuffle = true;                  // false: kernels that take subgroups for nothing even where DeviceInfo::shuffle; the same bytes
    bool ignoreWorkarounds = false;       // try a driver without the table in vk_device.cpp
    std::span<const uint8_t> shaderPack;  // built of other shaders than the SDK's, which do without it; copied
    uint64_t shaderInterface = 0;         // that such a pack's C++ was compiled with
    /** Counts validation warnings and errors; the texts go to the log. */
    std::shared_ptr<std::atomic<uint32_t>> validationMessages;
};

/** Devices with a graphics + compute queue and Vulkan 1.1, best first: discrete, integrated, virtual, other, software.
 *  Code::Unsupported when there is no Vulkan loader or no driver; an empty list when no device fits. Any thread. */
Result<std::vector<DeviceInfo>> listVulkanDevices();

Result<std::unique_ptr<Backend>> createVulkanBackend(const VulkanOptions& options);

}  // namespace dpl
