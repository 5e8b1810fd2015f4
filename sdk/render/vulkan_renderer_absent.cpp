// SPDX-License-Identifier: Apache-2.0
// Replaces the Vulkan renderer in builds with DOPPEL_VULKAN=OFF, so that they link. Every call fails with Code::Unsupported.
#include "sdk/render/vulkan_renderer.h"

namespace dpl {

Result<std::vector<DeviceInfo>> listVulkanDevices() {
    return std::vector<DeviceInfo>();
}

Result<std::unique_ptr<Renderer>> createVulkanRenderer(const VulkanOptions&, Fill) {
    return fail(Code::Unsupported, "this build has no Vulkan (DOPPEL_VULKAN=OFF); use the software renderer");
}

}  // namespace dpl
