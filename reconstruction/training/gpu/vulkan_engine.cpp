// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/vulkan_engine.h"

namespace dpl {
namespace training {  // generated from shaders/training
std::span<const uint8_t> embeddedShaderPack();
uint64_t embeddedShaderInterface();
}  // namespace training

Result<std::unique_ptr<GpuEngine>> createVulkanEngine(const vk::DeviceRequest& request) {
    DPL_TRY(ShaderPack pack,
            readShaderPack(training::embeddedShaderPack(), "the shader pack of training", training::embeddedShaderInterface()));
    const KernelNeeds needs = needsOf(pack);
    DPL_TRY(auto backend, vk::createBackend(request, std::move(pack)));
    return GpuEngine::create(std::move(backend), needs);
}

}  // namespace dpl
