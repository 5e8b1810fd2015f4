// SPDX-License-Identifier: Apache-2.0
// Vulkan 1.1 behind backend.h. No Vulkan type leaves this folder.
#pragma once

#include <memory>
#include <vector>

#include "sdk/backend/backend.h"

namespace dpl {

struct VulkanOptions {
    bool allowSoftwareDevice = false;  // also drivers that run on the CPU, such as lavapipe and SwiftShader
};

/** Devices with a graphics + compute queue and Vulkan 1.1, best first: discrete, integrated, virtual, other, software.
 *  Code::Unsupported when there is no Vulkan loader or no driver; an empty list when no device fits. Any thread. */
Result<std::vector<DeviceInfo>> listVulkanDevices();

/** Code::Unsupported when there is no loader, no driver or no device that fits; Code::Device or Code::OutOfMemory when the driver fails. */
Result<std::unique_ptr<Backend>> createVulkanBackend(const VulkanOptions& options);

}  // namespace dpl
