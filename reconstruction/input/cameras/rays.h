// SPDX-License-Identifier: Apache-2.0
// Rays through pixels, and the point nearest to several rays.
#pragma once

#include <optional>
#include <span>

#include "sdk/math/camera.h"

namespace dpl {

struct Ray {
    Vec3d origin{0}, direction{0, 0, 1};  // world; direction has unit length
};

/** Ray from the eye through `px` (pixels, centres at +0.5), world frame. */
inline Ray pixelRay(const Camerad& camera, const Vec2d& px) {
    const Vec3d view((px.x - camera.cx) / camera.fx, (px.y - camera.cy) / camera.fy, 1);
    return {camera.eye(), glm::normalize(glm::transpose(camera.viewFromWorldRotation) * view)};
}

/** The point with the least weighted sum of squared distances to the rays: Σ w (I − d dᵀ)(x − o) = 0. With robustM > 0, ten rounds of
 *  Geman-McClure reweighting reduce the weight of rays further than about `robustM` metres; 0 means plain least squares.
 *  nullopt when the rays are parallel, fewer than two, or not as many as the weights. */
std::optional<Vec3d> pointNearRays(std::span<const Ray> rays, std::span<const double> weights, double robustM);

}  // namespace dpl
