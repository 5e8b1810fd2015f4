// SPDX-License-Identifier: Apache-2.0
// Limbs of modelled people.
#pragma once

#include <algorithm>

#include "sdk/math/types.h"

namespace dpl {

/** Signed distance from a capsule around the line from a to b, metres, negative inside. */
inline float capsule(const Vec3f& p, const Vec3f& a, const Vec3f& b, float radius) {
    const float t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0f, 1.0f);
    return glm::length(p - a - t * (b - a)) - radius;
}

}  // namespace dpl
