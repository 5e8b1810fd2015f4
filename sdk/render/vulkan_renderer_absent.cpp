// SPDX-License-Identifier: Apache-2.0
// Stands in for the Vulkan renderer in builds with DOPPEL_VULKAN=OFF: says so instead of not linking.
#include "sdk/render/vulkan_renderer.h"

namespace dpl {

Result<std::vector<DeviceInfo>> listVulkanDevices() {
    return std::vector<DeviceInfo>();
}

Result<std::unique_ptr<Renderer>> createVulkanRenderer(const VulkanOptions&, Fill) {
    return fail(Code::Unsupported, "this build has no Vulkan (DOPPEL_VULKAN=OFF); use the software renderer");
}

}  // namespace dpl
