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

/** Makes the renderer that DplRenderer describes. Unsupported: not in this build, or no device. Device: the device draws wrong pixels. */
Result<std::unique_ptr<Renderer>> createRenderer(DplRenderer kind, const RendererOptions& options);

}  // namespace dpl::api
