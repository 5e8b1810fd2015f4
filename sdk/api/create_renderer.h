// Which renderer a context gets.
#pragma once

#include <memory>

#include "sdk/core/result.h"
#include "sdk/include/doppel/doppel.h"
#include "sdk/render/renderer.h"

namespace dpl::api {

/** As DplRenderer says; cullTriangles: as VulkanOptions says. Unsupported when the wanted one is not in this build or finds no device. */
Result<std::unique_ptr<Renderer>> createRenderer(DplRenderer kind, uint32_t threadCount, bool cullTriangles = true);

}  // namespace dpl::api
