// SPDX-License-Identifier: Apache-2.0
// What a program asks for when it wants splats written, on the CPU or on a GPU.
#pragma once

#include <array>
#include <optional>

#include "sdk/api/buffer_layout.h"
#include "sdk/math/types.h"

namespace dpl::api {

struct SplatRequest {
    uint32_t budget = 0, shDegree = 0;
    std::optional<Vec3f> eye;
};

/** InvalidArgument: a degree that does not exist, or an eye that is nowhere. */
Result<SplatRequest> requestOf(const DplSplatOptions* options);

/** By DplSplatProperty. */
std::array<BufferProperty, 8> splatProperties(uint32_t shDegree);

}  // namespace dpl::api
