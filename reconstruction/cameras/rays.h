// SPDX-License-Identifier: Apache-2.0
// Rays of pixels and the point that many of them share.
#pragma once

#include <optional>
#include <span>

#include "sdk/math/camera.h"

namespace dpl {

struct Ray {
    Vec3d origin{0}, direction{0, 0, 1};  // world; direction has unit length
};

inline Ray pixelRay(const Camerad& camera, const Vec2d& px) {
    const Vec3d view((px.x - camera.cx) / camera.fx, (px.y - camera.cy) / camera.fy, 1);
    return {camera.eye(), glm::normalize(glm::transpose(camera.viewFromWorldRotation) * view)};
}

/** The point with the least weighted sum of squared distances to the rays: Σ w (I − d dᵀ)(x − o) = 0. Rays further than `robustM` from it
 * lose weight by Geman–McClure over ten rounds; robustM 0 means plain least squares. Nothing when the rays are parallel or fewer than two.
 */
std::optional<Vec3d> pointNearRays(std::span<const Ray> rays, std::span<const double> weights, double robustM);

}  // namespace dpl
