// SPDX-License-Identifier: Apache-2.0
// A Metal device that does nothing at all: no call is checked, nothing runs, every command buffer has run at once. What is left of a frame
// is the time of the backend itself, so this is for benches.
#pragma once

#include <memory>

#include "sdk/backend/metal/mtl_seam.h"

namespace dpl::mtl {

std::unique_ptr<Seam> idleSeam();

}  // namespace dpl::mtl
