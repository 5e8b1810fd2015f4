#include "sdk/api/create_renderer.h"

#include "sdk/api/software_renderer.h"

namespace dpl::api {

Result<std::unique_ptr<Renderer>> createRenderer(DplRenderer kind, uint32_t threadCount) {
    if (kind == DPL_RENDERER_VULKAN)
        return fail(Code::Unsupported, "this build of Doppel has no Vulkan renderer yet; use DPL_RENDERER_AUTO or DPL_RENDERER_SOFTWARE");
    return createSoftwareRenderer(threadCount);
}

}  // namespace dpl::api
