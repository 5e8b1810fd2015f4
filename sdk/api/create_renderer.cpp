// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/create_renderer.h"

#include "sdk/api/api_state.h"
#include "sdk/core/log.h"
#include "sdk/splat/software_renderer.h"

// Of this build; undefined: no.
#ifndef DOPPEL_VULKAN
#define DOPPEL_VULKAN 0
#endif
#ifndef DOPPEL_METAL
#define DOPPEL_METAL 0
#endif
#define DOPPEL_GPU (DOPPEL_VULKAN || DOPPEL_METAL)
#if DOPPEL_GPU
#include "sdk/render/fill_memory.h"
#endif
#if DOPPEL_VULKAN
#include "sdk/render/vulkan_renderer.h"
#endif
#if DOPPEL_METAL
#include "sdk/render/metal_renderer.h"
#endif

namespace dpl::api {
#if DOPPEL_GPU
namespace {

const auto softwarePicture = [](const FillScene& scene) -> Result<std::vector<uint8_t>> {
    const std::unique_ptr<Renderer> software = createSoftwareRenderer(1);
    DPL_TRY(const RenderAvatarId id, software->addSplats(scene.splats));
    DPL_RETURN_IF_ERROR(software->draw(id, {}, {&scene.camera, 1}, false));
    DPL_TRY(const std::span<const PixelView> views, software->read(id));
    return std::vector<uint8_t>(views[0].rgba.begin(), views[0].rgba.end());
};

}  // namespace

Status setFill(Renderer& gpu, const RendererOptions& options) {
    if (options.fill == DPL_FILL_AUTO) return setBestFill(gpu, options.cacheFolder, softwarePicture);
    gpu.setFill(options.fill == DPL_FILL_TILES ? Fill::Tiles : Fill::Quads);
    return {};
}

namespace {

Result<std::unique_ptr<Renderer>> openVulkan([[maybe_unused]] DplRenderer kind) {
#if DOPPEL_VULKAN
    VulkanOptions vulkan;
    vulkan.allowSoftwareDevice = kind == DPL_RENDERER_VULKAN;  // asked for by name: software devices are allowed
    auto gpu = createVulkanRenderer(vulkan);
    if (!gpu && gpu.error().code != Code::Unsupported) return gpu.error();
    if (!gpu)
        return fail(Code::Unsupported, "no Vulkan renderer on this machine: {}; use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE",
                    gpu.error().message);
    return gpu;
#else
    return fail(Code::Unsupported,
                "this build of Doppel is without Vulkan (DOPPEL_VULKAN=OFF); use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE");
#endif
}

Result<std::unique_ptr<Renderer>> openMetal() {
#if DOPPEL_METAL
    return createMetalRenderer();
#else
    return fail(Code::Unsupported, "this build of Doppel is without Metal; use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE");
#endif
}

}  // namespace

Result<std::unique_ptr<Renderer>> createGpuRenderer(DplRenderer kind, const RendererOptions& options) {
    const bool metal = kind == DPL_RENDERER_METAL || (kind == DPL_RENDERER_AUTO && DOPPEL_METAL);
    DPL_TRY(auto gpu, metal ? openMetal() : openVulkan(kind));
    DPL_RETURN_IF_ERROR(setFill(*gpu, options));
    return gpu;
}
#endif

Result<ContextRequest> readContextInfo(const DplContextInfo* info) {
    if (info == nullptr) return ContextRequest();
    DPL_TRY(const DplContextInfo given, readStruct<DplContextInfo>(info, "info", offsetof(DplContextInfo, flags)));
    int32_t kind = 0, fill = 0;  // copied as integers: the caller's values may be outside the enums
    std::memcpy(&kind, &given.renderer, sizeof kind);
    std::memcpy(&fill, &given.fill, sizeof fill);
    if (given.flags != 0) return fail(Code::InvalidArgument, "info has unknown flags {}; there are none", given.flags);
    if (kind < DPL_RENDERER_AUTO || kind > DPL_RENDERER_METAL) return fail(Code::InvalidArgument, "there is no renderer {}", kind);
    if (fill < DPL_FILL_AUTO || fill > DPL_FILL_TILES) return fail(Code::InvalidArgument, "there is no fill {}", fill);
    if (given.threadCount > 256) return fail(Code::InvalidArgument, "{} threads; 0 to 256 are possible", given.threadCount);
    ContextRequest request;
    request.kind = DplRenderer(kind);
    request.options = {.threadCount = given.threadCount, .fill = DplFill(fill)};
    if (given.cacheFolder) request.options.cacheFolder = given.cacheFolder;
    return request;
}

Result<std::unique_ptr<Renderer>> createRenderer(DplRenderer kind, const RendererOptions& options) {
#if DOPPEL_GPU
    if (kind != DPL_RENDERER_SOFTWARE) {
        auto gpu = createGpuRenderer(kind, options);
        if (gpu || kind != DPL_RENDERER_AUTO) return gpu;
        log(gpu.error().code == Code::Unsupported ? LogLevel::Info : LogLevel::Warning, "no usable GPU, drawing on the CPU: {}",
            gpu.error().message);
    }
#else
    if (kind == DPL_RENDERER_VULKAN || kind == DPL_RENDERER_METAL)
        return fail(Code::Unsupported,
                    "this build of Doppel is without Vulkan (DOPPEL_VULKAN=OFF) and Metal; use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE");
#endif
    return createSoftwareRenderer(options.threadCount);
}

}  // namespace dpl::api
