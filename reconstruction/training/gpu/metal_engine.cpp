// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/metal_engine.h"

#include "sdk/backend/metal/mtl_backend.h"

namespace dpl {
namespace training {  // generated from shaders/training
std::span<const uint8_t> embeddedMetalPack();
uint64_t embeddedMetalInterface();
}  // namespace training

Result<std::unique_ptr<GpuEngine>> createMetalEngine(std::unique_ptr<mtl::Seam> seam) {
    DPL_TRY(ShaderPack pack,
            readShaderPack(training::embeddedMetalPack(), "the shader pack of training for Metal", training::embeddedMetalInterface()));
    const KernelNeeds needs = needsOf(pack);
    DPL_TRY(auto backend, mtl::createBackendOn(std::move(seam), /*lent=*/false, std::move(pack)));
    return GpuEngine::create(std::move(backend), needs);
}

}  // namespace dpl
