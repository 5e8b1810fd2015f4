// SPDX-License-Identifier: Apache-2.0
// General splats in the shape of a room: walls, floor and ceiling of flat splats several deep, and a ball in the middle. For tests of level
// of detail, with near and far splats in one picture.
#pragma once

#include <random>

#include "apps/reference/reference_detail.h"
#include "sdk/format/spatial_order.h"
#include "sdk/math/camera.h"

namespace dpl {

/** The room is 4 × 3 × 8 m around the origin; the ball has a radius of 0.5 m around (0, 0, -1). */
inline StaticSplatData splatRoom(uint32_t seed, uint32_t count, uint32_t shDegree = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::normal_distribution<float> normal;
    const Vec3f half(2, 1.5f, 4);
    StaticSplatData s;
    s.shDegree = shDegree;
    const float sizeM = 8 / std::sqrt(float(count));  // 76 m² of each pair of sides, about four deep
    for (uint32_t i = 0; i < count; ++i) {
        Vec3f at, front;
        if (i % 8 == 0) {
            front = glm::normalize(Vec3f(normal(random), normal(random), normal(random)));
            at = Vec3f(0, 0, -1) + 0.5f * front;
        } else {
            const int axis = i % 8 < 4 ? 0 : i % 8 < 6 ? 1 : 2;
            for (int k = 0; k < 3; ++k) at[k] = half[k] * (2 * uniform(random) - 1);
            front = Vec3f(0), front[axis] = i % 2 ? 1.0f : -1.0f, at[axis] = half[axis] * front[axis];
        }
        const Vec3f turnAxis(-front.y, front.x, 0);  // turns z to front
        const Quatf toFront = glm::length(turnAxis) > 1e-4f ? glm::angleAxis(std::acos(front.z), glm::normalize(turnAxis))
                              : front.z > 0                 ? Quatf(1, 0, 0, 0)
                                                            : Quatf(0, 1, 0, 0);
        s.position.push_back(at);
        s.rotation.push_back(glm::normalize(toFront * glm::angleAxis(6.28f * uniform(random), Vec3f(0, 0, 1))));
        const float size = (i % 8 == 0 ? 0.4f : 1.0f) * sizeM;
        s.scaleM.push_back(size * Vec3f(std::exp(0.4f * normal(random)), std::exp(0.4f * normal(random)), 0.1f));
        s.opacity.push_back(0.2f + 0.75f * uniform(random));
        for (uint32_t c = 0; c < (shDegree + 1) * (shDegree + 1) * 3; ++c)
            s.sh.push_back((c < 3 ? 0.5f * std::sin(at[int(c)] * 3) : 0.1f) * (1 + 0.3f * normal(random)));
    }
    return s;
}

/** The referee's splats at a level of detail of perPixel splats a pixel for these cameras. */
inline std::vector<ReferenceGaussian> reducedSplats(const StaticSplatData& splats, std::initializer_list<Cameraf> views, double perPixel) {
    std::vector<ReferenceCamera> cameras;
    for (const Cameraf& view : views) cameras.push_back(referenceCamera(view));
    return reducedReference(splats, spatialOrder(splats.position), cameras, perPixel);
}

}  // namespace dpl
