// SPDX-License-Identifier: Apache-2.0
// Vulkan 1.1 behind backend.h. No Vulkan type leaves this folder.
#pragma once

#include <memory>
#include <vector>

#include "sdk/backend/backend.h"

namespace dpl {

struct VulkanOptions {
    bool allowSoftwareDevice = false;  // also drivers that run on the CPU, such as lavapipe and SwiftShader
    // Switches for measuring (docs/adr/0027).
    bool cull = true;           // false: splats that face away, out of view or below 1/255 are sorted and drawn too (docs/adr/0014)
    bool shareViews = true;     // false: two views are two frames, even if one depth order is right for both (docs/adr/0015)
    bool quantiseDepth = true;  // false: sort by 32-bit float depths instead of 16-bit keys (docs/adr/0016)
};

/** Devices with a graphics + compute queue and Vulkan 1.1, best first: discrete, integrated, virtual, other, software.
 *  Code::Unsupported when there is no Vulkan loader or no driver; an empty list when no device fits. Any thread. */
Result<std::vector<DeviceInfo>> listVulkanDevices();

/** Code::Unsupported when there is no loader, no driver or no device that fits; Code::Device or Code::OutOfMemory when the driver fails. */
Result<std::unique_ptr<Backend>> createVulkanBackend(const VulkanOptions& options);

}  // namespace dpl
