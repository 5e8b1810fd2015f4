// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/camera_convention.h"

#include <cmath>
#include <limits>

namespace dpl {

void turnZUpWorld(Camerad& camera) {
    // P = C p with C p = (x, z, −y), so R p = (R·Cᵀ) P. The columns of R·Cᵀ are those of R: x, z, −y.
    Mat3d& r = camera.viewFromWorldRotation;
    r = Mat3d(r[0], r[2], -r[1]);
}

Vec3d turnZUpPoint(const Vec3d& p) {
    return {p.x, p.z, -p.y};
}

void setOpenglPose(Camerad& camera, std::span<const double, 16> m) {
    // The columns of world-from-camera are right, up, backward and position. The rows of R are OpenCV's axes: right, −up, −backward.
    const Vec3d right(m[0], m[4], m[8]), up(m[1], m[5], m[9]), back(m[2], m[6], m[10]), eye(m[3], m[7], m[11]);
    camera.viewFromWorldRotation = glm::transpose(Mat3d(right, -up, -back));
    camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * eye);
}

void setColmapPose(Camerad& camera, std::span<const double, 4> q, const Vec3d& translation) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    if (!(length > 1e-12) || !std::isfinite(length))
        camera.viewFromWorldRotation = Mat3d(nan);
    else
        camera.viewFromWorldRotation = glm::mat3_cast(Quatd(q[0] / length, q[1] / length, q[2] / length, q[3] / length));
    camera.viewFromWorldTranslation = translation;
}

}  // namespace dpl
