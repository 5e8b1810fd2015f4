// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/camera_check.h"
#include "reconstruction/base/image_size.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr double kMinFovRad = 0.0175, kMaxFovRad = 2.618;  // 1° and 150°; values outside mean a wrong unit (mm for px) or a fisheye
constexpr double kRotationTolerance = 1e-3;                // accepts matrices written with four decimals, refuses scale and shear

Status checkFov(double focalPx, uint32_t sizePx, const char* name, std::string_view where) {
    if (!std::isfinite(focalPx) || focalPx <= 0)
        return fail(Code::CorruptData, "{}: {} is {}, a focal length in pixels above 0 is needed; write the calibrated value", where, name,
                    focalPx);
    const double fov = 2 * std::atan(0.5 * sizePx / focalPx);
    if (fov < kMinFovRad || fov > kMaxFovRad)
        return fail(Code::CorruptData,
                    "{}: {} = {} px over {} px is a field of view of {} degrees; give the focal length in pixels of this image size", where,
                    name, focalPx, sizePx, fov * 57.29577951308232);
    return {};
}

}  // namespace

Status checkCamera(Camerad& camera, std::string_view where) {
    DPL_RETURN_IF_ERROR(checkImageSize(camera.widthPx, camera.heightPx, where));
    DPL_RETURN_IF_ERROR(checkFov(camera.fx, camera.widthPx, "fx", where));
    DPL_RETURN_IF_ERROR(checkFov(camera.fy, camera.heightPx, "fy", where));
    if (camera.fx > 2 * camera.fy || camera.fy > 2 * camera.fx)
        return fail(Code::CorruptData, "{}: fx = {} and fy = {} differ by more than a factor of two; check the intrinsics", where,
                    camera.fx, camera.fy);
    const bool inX = camera.cx >= -0.5 * camera.widthPx && camera.cx <= 1.5 * camera.widthPx;
    const bool inY = camera.cy >= -0.5 * camera.heightPx && camera.cy <= 1.5 * camera.heightPx;
    if (!inX || !inY)  // also true for NaN
        return fail(Code::CorruptData, "{}: principal point ({}, {}) is far outside the {} x {} image; check cx, cy and the image size",
                    where, camera.cx, camera.cy, camera.widthPx, camera.heightPx);
    Mat3d& r = camera.viewFromWorldRotation;
    const Vec3d& t = camera.viewFromWorldTranslation;
    if (!std::isfinite(t.x) || !std::isfinite(t.y) || !std::isfinite(t.z))
        return fail(Code::CorruptData, "{}: the translation is not finite; register this camera again or remove the frame", where);
    if (std::max({std::abs(t.x), std::abs(t.y), std::abs(t.z)}) > 1e6)
        return fail(Code::CorruptData, "{}: the camera is more than 1e6 units away; check the units of t", where);
    double worst = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const double error = std::abs(glm::dot(r[i], r[j]) - (i == j ? 1.0 : 0.0));
            if (!(error <= worst)) worst = error;
            if (!std::isfinite(error))
                return fail(Code::CorruptData, "{}: the rotation is not finite; register this camera again or remove the frame", where);
        }
    if (!(worst <= kRotationTolerance))
        return fail(Code::CorruptData,
                    "{}: R is not a rotation (columns are off orthonormal by {}); check the order of its nine numbers and any scale in it",
                    where, worst);
    if (glm::determinant(r) < 0)
        return fail(Code::CorruptData, "{}: R mirrors (determinant -1); an axis has the wrong sign, check the camera convention", where);
    for (int i = 0; i < 3; ++i)
        r = 0.5 * (r + glm::transpose(glm::inverse(r)));  // Newton's polar iteration squares the error: 1e-3, 1e-7, 1e-14
    return {};
}

Status checkDistortion(const LensDistortion& lens, const Camerad& camera, std::string_view where) {
    if (!std::isfinite(lens.k1) || !std::isfinite(lens.k2) || !std::isfinite(lens.p1) || !std::isfinite(lens.p2))
        return fail(Code::CorruptData, "{}: lens distortion is not finite; calibrate again or undistort the images first", where);
    if (std::abs(lens.p1) > 0.1 || std::abs(lens.p2) > 0.1)
        return fail(Code::CorruptData, "{}: tangential distortion ({}, {}) is implausibly large; undistort the images first", where,
                    lens.p1, lens.p2);
    // Invertible if d/dr of r(1 + k1 r² + k2 r⁴) is positive out to the farthest corner. Real lenses stay between 0.2 and 2.
    constexpr double kFolds = 0.05, kSteepest = 4;
    const double x = std::max(camera.cx, camera.widthPx - camera.cx) / camera.fx,
                 y = std::max(camera.cy, camera.heightPx - camera.cy) / camera.fy;
    const double corner2 = x * x + y * y;
    for (int i = 1; i <= 64; ++i) {
        const double r2 = corner2 * i / 64;
        const double slope = 1 + 3 * lens.k1 * r2 + 5 * lens.k2 * r2 * r2;
        if (slope > kSteepest)
            return fail(
                Code::CorruptData,
                "{}: the lens model (k1 = {}, k2 = {}) stretches the edge of the image {} times, which no lens does; calibrate again "
                "or undistort the images first",
                where, lens.k1, lens.k2, slope);
        if (slope <= kFolds)
            return fail(Code::Unsupported,
                        "{}: the lens model (k1 = {}, k2 = {}) folds over inside the image; undistort the images first, for example with "
                        "'colmap image_undistorter'",
                        where, lens.k1, lens.k2);
    }
    return {};
}

}  // namespace dpl
