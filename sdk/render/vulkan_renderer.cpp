// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/vulkan_renderer.h"

#include "sdk/render/gpu_renderer.h"

namespace dpl {

Result<std::unique_ptr<Renderer>> createVulkanRenderer(const VulkanOptions& options, Fill fill) {
    DPL_TRY(auto backend, createVulkanBackend(options));
    std::string name = "vulkan: " + backend->info().name;
    return std::unique_ptr<Renderer>(std::make_unique<GpuRenderer>(std::move(backend), std::move(name), fill));
}

}  // namespace dpl
