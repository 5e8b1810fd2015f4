// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/vulkan_renderer.h"

#include "sdk/backend/vulkan/vulkan_test_options.h"
#include "sdk/render/gpu_renderer.h"

namespace dpl {

Result<std::unique_ptr<Renderer>> createVulkanRenderer(const VulkanOptions& options, Fill fill) {
    return createVulkanRenderer(VulkanTestOptions{options}, fill);
}

Result<std::unique_ptr<Renderer>> createVulkanRenderer(const VulkanTestOptions& options, Fill fill) {
    DPL_TRY(auto backend, createVulkanBackend(options));
    std::string name = "vulkan: " + backend->info().name;
    return std::unique_ptr<Renderer>(
        std::make_unique<GpuRenderer>(std::move(backend), std::move(name),
                                      GpuOptions{options.preciseBlending, options.cull, options.shareViews, options.quantiseDepth, fill}));
}

}  // namespace dpl
