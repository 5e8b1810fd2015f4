// SPDX-License-Identifier: Apache-2.0
// Makes the renderer of a context.
#pragma once

#include <memory>
#include <string>

#include "sdk/core/result.h"
#include "sdk/draw/renderer.h"
#include "sdk/include/doppel/doppel.h"

namespace dpl::api {

struct RendererOptions {
    uint32_t threadCount = 0;
    DplFill fill = DPL_FILL_AUTO;
    std::string cacheFolder;  // DplContextInfo::cacheFolder; empty: none
};

/** What a DplContextInfo asks for. */
struct ContextRequest {
    DplRenderer kind = DPL_RENDERER_AUTO;
    RendererOptions options;
};

/** Checks and reads a DplContextInfo; NULL: all defaults. */
Result<ContextRequest> readContextInfo(const DplContextInfo* info);

/** Sets the fill that the options ask for; DPL_FILL_AUTO: by the self-test. Device: the device draws wrong pixels. Only in builds with
 *  Vulkan or Metal. */
Status setFill(Renderer& gpu, const RendererOptions& options);

/** Makes a renderer on the best GPU: by Metal where it is built in, else by Vulkan, or by the one that `kind` names. DPL_RENDERER_VULKAN:
 *  or on an emulated one. Errors as createRenderer. Only in builds with Vulkan or Metal. */
Result<std::unique_ptr<Renderer>> createGpuRenderer(DplRenderer kind, const RendererOptions& options);

/** Whether the renderer is one of createMetalRenderer() or dplCreateMetalContext(). */
inline bool drawsByMetal(const Renderer& renderer) {
    return renderer.name().starts_with("metal: ");
}

/** Makes the renderer that DplRenderer describes. Unsupported: not in this build, or no device. Device: the device draws wrong pixels. */
Result<std::unique_ptr<Renderer>> createRenderer(DplRenderer kind, const RendererOptions& options);

}  // namespace dpl::api
