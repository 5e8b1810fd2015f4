// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/orbit_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dpl {

Mat3d OrbitCamera::worldFromView() const {
    const Vec3d back(std::cos(elevationRad_) * std::sin(azimuthRad_), std::sin(elevationRad_),
                     std::cos(elevationRad_) * std::cos(azimuthRad_));
    const Vec3d right(std::cos(azimuthRad_), 0, -std::sin(azimuthRad_));
    return Mat3d(right, glm::cross(-back, right), -back);
}

Vec3d OrbitCamera::offsetM(double rightPx, double downPx, double heightPx) const {
    const double metresPerPixel = 2 * distanceM_ * std::tan(fovYRad_ / 2) / heightPx;
    const Mat3d axes = worldFromView();
    return metresPerPixel * (rightPx * axes[0] + downPx * axes[1]);
}

void OrbitCamera::orbit(double rightPx, double downPx, double heightPx) {
    const double perPixel = std::numbers::pi / heightPx;
    azimuthRad_ = std::remainder(azimuthRad_ - rightPx * perPixel, 2 * std::numbers::pi);
    elevationRad_ = std::clamp(elevationRad_ + downPx * perPixel, -kMaxElevationRad, kMaxElevationRad);
}

void OrbitCamera::pan(double rightPx, double downPx, double heightPx) {
    middle_ -= offsetM(rightPx, downPx, heightPx);
}

void OrbitCamera::zoom(double steps, double rightPx, double downPx, double heightPx) {
    const Vec3d held = middle_ + offsetM(rightPx, downPx, heightPx);
    distanceM_ = std::clamp(distanceM_ * std::pow(0.9, steps), kMinDistanceM, kMaxDistanceM);
    middle_ = held - offsetM(rightPx, downPx, heightPx);
}

void OrbitCamera::lookCloserAt(const Vec3d& point) {
    middle_ = point;
    distanceM_ = std::max(0.5 * distanceM_, kMinDistanceM);
}

void OrbitCamera::setFovY(double rad) {
    const double before = std::tan(fovYRad_ / 2);
    fovYRad_ = std::clamp(rad, kLeastFovYRad, kMostFovYRad);
    distanceM_ = std::clamp(distanceM_ * before / std::tan(fovYRad_ / 2), kMinDistanceM, kMaxDistanceM);
}

void OrbitCamera::keepAway(double leastM) {
    distanceM_ = std::max(distanceM_, std::min(leastM, kMaxDistanceM));
}

void OrbitCamera::frame(const WorldBox& box, double aspect) {
    constexpr double kMargin = 1.12;
    const Vec3d half = 0.5 * (box.high - box.low);
    const double across = std::hypot(half.x, half.z), tall = half.y * std::cos(elevationRad_) + across * std::abs(std::sin(elevationRad_));
    const double tangent = std::tan(fovYRad_ / 2);
    middle_ = 0.5 * (box.low + box.high);
    distanceM_ = std::clamp(kMargin * std::max(tall / tangent, across / (tangent * aspect)) + across, kMinDistanceM, kMaxDistanceM);
}

Camerad OrbitCamera::camera(uint32_t widthPx, uint32_t heightPx, double centreXPx) const {
    const Mat3d axes = worldFromView();
    Camerad camera;
    camera.widthPx = widthPx, camera.heightPx = heightPx;
    camera.fx = camera.fy = 0.5 * heightPx / std::tan(fovYRad_ / 2);
    camera.cx = centreXPx, camera.cy = 0.5 * heightPx;
    camera.viewFromWorldRotation = glm::transpose(axes);
    camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * (middle_ - distanceM_ * axes[2]));
    return camera;
}

}  // namespace dpl
