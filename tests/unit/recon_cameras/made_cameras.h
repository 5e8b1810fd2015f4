// SPDX-License-Identifier: Apache-2.0
// Cameras and points that the tests of this folder make up.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "sdk/math/camera.h"

namespace dpl {

inline Mat3d turnAbout(const Vec3d& axis, double angleRad) {
    const Vec3d n = glm::normalize(axis);
    return glm::mat3_cast(Quatd(std::cos(angleRad / 2), std::sin(angleRad / 2) * n));
}

/** Puts the camera at `eye`, with its axis through `target` and world +Y up. */
inline void lookFrom(Camerad& camera, const Vec3d& eye, const Vec3d& target) {
    const Vec3d forward = glm::normalize(target - eye), right = glm::normalize(glm::cross(forward, Vec3d(0, 1, 0)));
    camera.viewFromWorldRotation = glm::transpose(Mat3d(right, glm::cross(forward, right), forward));
    camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * eye);
}

/** `count` cameras of 378 × 504 px on a circle of 2 m about (0, 1, 0), at heights from 0.8 to 1.8 m. */
inline std::vector<Camerad> orbit(size_t count) {
    std::vector<Camerad> cameras(count);
    for (size_t i = 0; i < count; ++i) {
        cameras[i].widthPx = 378, cameras[i].heightPx = 504;
        cameras[i].fx = cameras[i].fy = 380, cameras[i].cx = 189, cameras[i].cy = 252;
        const double angle = 2 * std::numbers::pi * double(i) / double(count);
        lookFrom(cameras[i], {2 * std::sin(angle), 1.3 + 0.5 * std::sin(3 * angle), 2 * std::cos(angle)}, {0, 1, 0});
    }
    return cameras;
}

/** Points of a room of 6 × 3 × 6 m about the orbit: walls, floor and ceiling. */
inline std::vector<Vec3d> roomPoints(size_t count, uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<Vec3d> points;
    for (size_t i = 0; i < count; ++i) {
        Vec3d p{3 * uniform(random), 1.5 + 1.5 * uniform(random), 3 * uniform(random)};
        const int side = int(i % 3);
        p[side] = side == 1 ? (uniform(random) < 0 ? 0.0 : 3.0) : (uniform(random) < 0 ? -3.0 : 3.0);
        points.push_back(p);
    }
    return points;
}

}  // namespace dpl
