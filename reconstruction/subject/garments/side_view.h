// SPDX-License-Identifier: Apache-2.0
// The fixed views from which faults of clothes are counted: level, from four sides, 5 mm a pixel.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "sdk/math/camera.h"
#include "sdk/math/types.h"

namespace dpl {

constexpr int kSides = 4;
constexpr double kSideEyeM = 4, kSidePixelM = 0.005, kSideMarginM = 0.1;

/** Looks level at the middle of a posed mesh from one of kSides sides. */
inline Camerad sideView(std::span<const Vec3f> positions, int side) {
    Vec3f low(1e30f), high(-1e30f);
    for (const Vec3f& p : positions) low = glm::min(low, p), high = glm::max(high, p);
    const Vec3d middle = 0.5 * Vec3d(low + high);
    const double angle = 2 * 3.14159265358979 * side / kSides;
    const Vec3d back(std::sin(angle), 0, std::cos(angle)), z = -back, y(0, -1, 0), x = glm::cross(y, z);
    Camerad camera;
    camera.fx = camera.fy = kSideEyeM / kSidePixelM;
    const auto pixels = [](double metres) { return uint32_t((std::min(metres, 3.0) + 2 * kSideMarginM) / kSidePixelM); };
    camera.widthPx = pixels(std::hypot(high.x - low.x, high.z - low.z)), camera.heightPx = pixels(high.y - low.y);
    camera.cx = 0.5 * camera.widthPx, camera.cy = 0.5 * camera.heightPx;
    camera.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
    camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * (middle + kSideEyeM * back));
    return camera;
}

}  // namespace dpl
