// SPDX-License-Identifier: Apache-2.0
// Creates the GPU renderer on the system's Metal device.
#pragma once

#include "sdk/draw/renderer.h"

namespace dpl {

/** Code::Unsupported when there is no Metal device that fits. */
Result<std::unique_ptr<Renderer>> createMetalRenderer(Fill fill = Fill::Quads);

}  // namespace dpl
