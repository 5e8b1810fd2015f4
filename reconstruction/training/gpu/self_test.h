// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstruction/training/gpu/gpu_engine.h"

namespace dpl {

/** Compares the gradients of a small picture with those of the CPU. Unsupported: they differ, so the driver computes wrong. The engine
 *  afterwards holds the splats of the test. */
Status testEngine(GpuEngine& engine);

}  // namespace dpl
