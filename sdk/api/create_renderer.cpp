#include "sdk/api/create_renderer.h"

#include "sdk/api/software_renderer.h"
#include "sdk/core/log.h"
#if DOPPEL_VULKAN
#include "sdk/render/vulkan_renderer.h"
#endif

namespace dpl::api {

Result<std::unique_ptr<Renderer>> createRenderer(DplRenderer kind, uint32_t threadCount, bool cullTriangles) {
#if DOPPEL_VULKAN
    if (kind != DPL_RENDERER_SOFTWARE) {
        VulkanOptions options;
        options.allowSoftwareDevice = kind == DPL_RENDERER_VULKAN;  // asked for by name, any device will do
        options.cullTriangles = cullTriangles;
        auto gpu = createVulkanRenderer(options);
        if (gpu) return gpu;
        if (kind == DPL_RENDERER_VULKAN) {
            // "No usable loader" and "no device" are one thing to the caller: not on this machine.
            return fail(Code::Unsupported, "no Vulkan renderer on this machine: {}; use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE", gpu.error().message);
        }
        log(LogLevel::Info, "no GPU to draw with, the CPU draws: {}", gpu.error().message);
    }
#else
    if (kind == DPL_RENDERER_VULKAN)
        return fail(Code::Unsupported, "this build of Doppel is without Vulkan (DOPPEL_VULKAN=OFF); use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE");
#endif
    return createSoftwareRenderer(threadCount);
}

}  // namespace dpl::api
