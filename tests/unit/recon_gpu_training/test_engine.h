// SPDX-License-Identifier: Apache-2.0
// The engine of a test program. Programs for different graphics APIs define it.
#pragma once

#include "reconstruction/training/gpu/gpu_engine.h"

namespace dpl::test {

/** One for the whole program; null, with the reason printed, where there is none. Each call expects that the device found no fault so far.
 */
GpuEngine* testEngine();

}  // namespace dpl::test
