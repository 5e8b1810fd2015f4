// SPDX-License-Identifier: Apache-2.0
// The engine on a Metal device.
#pragma once

#include "reconstruction/training/gpu/gpu_engine.h"
#include "sdk/backend/metal/mtl_seam.h"

namespace dpl {

/** Unsupported: the device is too old for Doppel's Metal. */
Result<std::unique_ptr<GpuEngine>> createMetalEngine(std::unique_ptr<mtl::Seam> seam);

}  // namespace dpl
