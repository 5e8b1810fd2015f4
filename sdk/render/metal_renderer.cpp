// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/metal_renderer.h"

#include "sdk/backend/metal/metal_backend.h"
#include "sdk/render/gpu_renderer.h"

namespace dpl {

Result<std::unique_ptr<Renderer>> createMetalRenderer(Fill fill) {
    DPL_TRY(auto backend, createMetalBackend());
    std::string name = "metal: " + backend->info().name;
    return std::unique_ptr<Renderer>(std::make_unique<GpuRenderer>(std::move(backend), std::move(name), fill));
}

}  // namespace dpl
