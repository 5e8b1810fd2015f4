// SPDX-License-Identifier: Apache-2.0
// Which renderer a context gets.
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
    std::string cacheFolder;  // empty: none
};

/** As DplRenderer says. Unsupported when the wanted one is not in this build or finds no device; Device when it draws wrong pixels. */
Result<std::unique_ptr<Renderer>> createRenderer(DplRenderer kind, const RendererOptions& options);

}  // namespace dpl::api
