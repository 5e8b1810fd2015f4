// SPDX-License-Identifier: Apache-2.0
// A camera on a sphere around a point.
#pragma once

#include <cmath>

#include "sdk/math/camera.h"

namespace dpl {

/** Looks at `target` from distanceM. Azimuth 0 looks from +Z and turns towards +X; elevation, radians, rises towards +Y and stays below
 *  ±π/2. The target lies in the middle of the picture. */
inline Camerad orbitCamera(const Vec3d& target, double distanceM, double azimuthRad, double elevationRad, double focalPx, uint32_t widthPx,
                           uint32_t heightPx) {
    const Vec3d back(std::cos(elevationRad) * std::sin(azimuthRad), std::sin(elevationRad), std::cos(elevationRad) * std::cos(azimuthRad));
    const Vec3d forward = -back, right = glm::normalize(glm::cross(forward, Vec3d(0, 1, 0))), down = glm::cross(forward, right);
    Camerad camera{widthPx, heightPx, focalPx, focalPx, widthPx / 2.0, heightPx / 2.0, glm::transpose(Mat3d(right, down, forward)), {}};
    camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * (target + distanceM * back));
    return camera;
}

/** A square picture of a box, from twice its diagonal away, so that it fits from all sides. Angles as above. */
inline Camerad orbitBox(const Vec3f& low, const Vec3f& high, double azimuthRad, double elevationRad, uint32_t sidePx) {
    return orbitCamera(0.5 * Vec3d(low + high), 2 * double(glm::length(high - low)), azimuthRad, elevationRad, 1.7 * sidePx, sidePx,
                       sidePx);
}

}  // namespace dpl
