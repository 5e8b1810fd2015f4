// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/create_renderer.h"

#include "sdk/core/log.h"
#include "sdk/splat/software_renderer.h"
#if DOPPEL_VULKAN
#include "sdk/render/fill_memory.h"
#include "sdk/render/vulkan_renderer.h"
#endif

namespace dpl::api {
#if DOPPEL_VULKAN
namespace {

const auto softwarePicture = [](const FillScene& scene) -> Result<std::vector<uint8_t>> {
    const std::unique_ptr<Renderer> software = createSoftwareRenderer(1);
    DPL_TRY(const RenderAvatarId id, software->addSplats(scene.splats));
    DPL_CHECK_OK(software->draw(id, {}, {&scene.camera, 1}, false));
    DPL_TRY(const std::span<const PixelView> views, software->read(id));
    return std::vector<uint8_t>(views[0].rgba.begin(), views[0].rgba.end());
};

Result<std::unique_ptr<Renderer>> createGpuRenderer(DplRenderer kind, const RendererOptions& options) {
    VulkanOptions vulkan;
    vulkan.allowSoftwareDevice = kind == DPL_RENDERER_VULKAN;  // asked for by name: software devices are allowed
    auto gpu = createVulkanRenderer(vulkan);
    if (!gpu && gpu.error().code != Code::Unsupported) return gpu.error();
    if (!gpu)
        return fail(Code::Unsupported, "no Vulkan renderer on this machine: {}; use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE",
                    gpu.error().message);
    if (options.fill == DPL_FILL_AUTO) {
        DPL_CHECK_OK(setBestFill(**gpu, options.cacheFolder, softwarePicture));
    } else {
        (*gpu)->setFill(options.fill == DPL_FILL_TILES ? Fill::Tiles : Fill::Quads);
    }
    return gpu;
}

}  // namespace
#endif

Result<std::unique_ptr<Renderer>> createRenderer(DplRenderer kind, const RendererOptions& options) {
#if DOPPEL_VULKAN
    if (kind != DPL_RENDERER_SOFTWARE) {
        auto gpu = createGpuRenderer(kind, options);
        if (gpu || kind == DPL_RENDERER_VULKAN) return gpu;
        log(gpu.error().code == Code::Unsupported ? LogLevel::Info : LogLevel::Warning, "no usable GPU, drawing on the CPU: {}",
            gpu.error().message);
    }
#else
    if (kind == DPL_RENDERER_VULKAN)
        return fail(Code::Unsupported,
                    "this build of Doppel is without Vulkan (DOPPEL_VULKAN=OFF); use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE");
#endif
    return createSoftwareRenderer(options.threadCount);
}

}  // namespace dpl::api
