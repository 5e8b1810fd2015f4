// SPDX-License-Identifier: Apache-2.0
// Cameras that are aimed, and what engines and headsets use, converted to what Doppel uses.
#include "sdk/include/doppel/doppel_convert.h"

#include <cmath>
#include <numbers>

#include "sdk/api/api_state.h"
#include "sdk/draw/check_draw.h"
#include "sdk/math/types.h"

namespace dpl::api {
namespace {

constexpr double kMaxAngleRad = 89.9 * std::numbers::pi / 180;
// Sine of the angle between up and the view direction. Both come from floats, which are off by some 1e-7; at this angle that turns the
// picture by a tenth of a radian.
constexpr double kLeastUpSine = 1e-6;

/** Three finite numbers. name: of the argument, for the error. */
Result<Vec3d> vectorOf(const float* given, const char* name) {
    if (!given) return fail(Code::InvalidArgument, "{} is NULL", name);
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(given[i]))
            return fail(Code::InvalidArgument, "{} is not finite: ({}, {}, {})", name, given[0], given[1], given[2]);
    return Vec3d(given[0], given[1], given[2]);
}

/** x, y, z, w of length 1. */
Result<Vec4d> orientationOf(const float* given) {
    if (!given) return fail(Code::InvalidArgument, "orientation is NULL");
    const Vec4d q(given[0], given[1], given[2], given[3]);
    const double length = glm::length(q);
    if (!(length > 1e-6) || !std::isfinite(length))
        return fail(Code::InvalidArgument, "the orientation ({}, {}, {}, {}) is no rotation", q.x, q.y, q.z, q.w);
    return q / length;
}

struct Lens {
    double fx, fy, cx, cy;  // pixels
};

/** Where an eye is, and its axes in the world, of length 1. */
struct Eye {
    Vec3d position, right, down, forward;
};

/** The eye of a pose that looks along -z with y up. */
Result<Eye> eyeOf(const float* orientation, const float* position) {
    DPL_TRY(const Vec4d q, orientationOf(orientation));
    DPL_TRY(const Vec3d p, vectorOf(position, "position"));
    // Columns of the rotation: the eye's right, up and backward in the world.
    const Vec3d right(1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.z * q.w), 2 * (q.x * q.z - q.y * q.w));
    const Vec3d up(2 * (q.x * q.y - q.z * q.w), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z + q.x * q.w));
    return Eye{p, right, -up, -glm::cross(right, up)};
}

Status writeCamera(const Eye& eye, const Lens& lens, uint32_t widthPx, uint32_t heightPx, DplCamera* camera) {
    const Vec3d rows[3] = {eye.right, eye.down, eye.forward};
    DplCamera made{};
    made.widthPx = widthPx, made.heightPx = heightPx;
    made.fx = float(lens.fx), made.fy = float(lens.fy), made.cx = float(lens.cx), made.cy = float(lens.cy);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) made.viewFromWorld[4 * row + column] = float(rows[row][column]);
        made.viewFromWorld[4 * row + 3] = float(-glm::dot(rows[row], eye.position));
    }
    return writeStruct(camera, made, "camera");
}

Status checkSize(uint32_t widthPx, uint32_t heightPx) {
    if (widthPx == 0 || heightPx == 0 || widthPx > DPL_MAX_IMAGE_SIDE_PX || heightPx > DPL_MAX_IMAGE_SIDE_PX)
        return fail(Code::InvalidArgument, "the view has {} x {} pixels; sides from 1 to {} are possible", widthPx, heightPx,
                    DPL_MAX_IMAGE_SIDE_PX);
    return {};
}

Status cameraLookAt(const float* eye, const float* target, const float* up, float fovYRad, uint32_t widthPx, uint32_t heightPx,
                    DplCamera* camera) {
    DPL_TRY(const Vec3d from, vectorOf(eye, "eye"));
    DPL_TRY(const Vec3d to, vectorOf(target, "target"));
    DPL_TRY(const Vec3d above, vectorOf(up, "up"));
    DPL_RETURN_IF_ERROR(checkSize(widthPx, heightPx));
    if (!(fovYRad > 0 && fovYRad <= 2 * kMaxAngleRad))
        return fail(Code::InvalidArgument, "fovYRad is {}; radians above 0 and up to {} (179.8 degrees) are possible", fovYRad,
                    2 * kMaxAngleRad);
    const double focalPx = 0.5 * heightPx / std::tan(0.5 * fovYRad);
    if (focalPx > kMaxIntrinsicPx)
        return fail(Code::InvalidArgument, "fovYRad is {}, a focal length of {} px; up to {} px are drawn", fovYRad, focalPx,
                    kMaxIntrinsicPx);
    if (glm::length(from) > kMaxDistanceM)
        return fail(Code::InvalidArgument, "the eye is {} m from the origin; avatars are drawn from up to {} m", glm::length(from),
                    kMaxDistanceM);
    if (from == to)
        return fail(Code::InvalidArgument, "eye and target are one point, ({}, {}, {}): where to look?", from.x, from.y, from.z);
    if (above == Vec3d(0)) return fail(Code::InvalidArgument, "up is zero; (0, 1, 0) is usual");
    const Vec3d forward = glm::normalize(to - from), aside = glm::cross(forward, glm::normalize(above));
    const double sine = glm::length(aside);
    if (!(sine >= kLeastUpSine))
        return fail(Code::InvalidArgument,
                    "up is parallel to the view direction ({}, {}, {}), so nothing says what is up in the picture; give {}", forward.x,
                    forward.y, forward.z, std::abs(forward.y) > 0.5 ? "(0, 0, -1)" : "(0, 1, 0)");
    const Vec3d right = aside / sine;
    return writeCamera({from, right, glm::cross(forward, right), forward}, {focalPx, focalPx, 0.5 * widthPx, 0.5 * heightPx}, widthPx,
                       heightPx, camera);
}

Status cameraFromAngles(const float* orientation, const float* position, const float* anglesRad, uint32_t widthPx, uint32_t heightPx,
                        DplCamera* camera) {
    if (!anglesRad) return fail(Code::InvalidArgument, "anglesRad is NULL");
    DPL_RETURN_IF_ERROR(checkSize(widthPx, heightPx));
    for (int i = 0; i < 4; ++i)
        if (!(std::abs(anglesRad[i]) <= kMaxAngleRad))
            return fail(Code::InvalidArgument, "an edge of the view is {} rad from its axis; 89.9 degrees are possible", anglesRad[i]);
    const double left = std::tan(double(anglesRad[0])), right = std::tan(double(anglesRad[1]));
    const double top = std::tan(double(anglesRad[2])), bottom = std::tan(double(anglesRad[3]));
    if (!(left < right && bottom < top))
        return fail(Code::InvalidArgument, "the view is empty or mirrored: left {}, right {}, top {}, bottom {} rad", anglesRad[0],
                    anglesRad[1], anglesRad[2], anglesRad[3]);
    const double fx = widthPx / (right - left), fy = heightPx / (top - bottom);
    DPL_TRY(const Eye eye, eyeOf(orientation, position));
    return writeCamera(eye, {fx, fy, -left * fx, top * fy}, widthPx, heightPx, camera);
}

/** What a projection matrix says of a camera. Stored depth = depthScale + depthOffset / view z. */
struct ProjectionFacts {
    Lens lens;
    float depthScale, depthOffset;
};

Result<ProjectionFacts> readProjection(const float* projection, DplClipDepth clipDepth, uint32_t widthPx, uint32_t heightPx) {
    if (!projection) return fail(Code::InvalidArgument, "projection is NULL");
    DPL_RETURN_IF_ERROR(checkSize(widthPx, heightPx));
    if (clipDepth != DPL_CLIP_DEPTH_ZERO_TO_ONE && clipDepth != DPL_CLIP_DEPTH_MINUS_ONE_TO_ONE)
        return fail(Code::InvalidArgument, "there is no clip depth {}", int(clipDepth));
    const auto at = [&](int row, int column) { return double(projection[4 * column + row]); };
    for (int i = 0; i < 16; ++i)
        if (!std::isfinite(projection[i])) return fail(Code::InvalidArgument, "the projection is not finite");
    if (at(3, 2) == 0 || at(3, 0) != 0 || at(3, 1) != 0 || at(3, 3) != 0)
        return fail(Code::InvalidArgument, "the projection is no perspective one: its last row must be 0, 0, ±1, 0");
    if (at(0, 1) != 0 || at(0, 3) != 0 || at(1, 0) != 0 || at(1, 3) != 0 || at(2, 0) != 0 || at(2, 1) != 0)
        return fail(Code::InvalidArgument, "the projection is skewed; only focal lengths, a centre and a depth range are possible");
    if (at(0, 0) <= 0 || at(1, 1) == 0 || at(2, 3) == 0)
        return fail(Code::InvalidArgument, "the projection mirrors x, or squashes y or depth to nothing");
    const double forward = at(3, 2) > 0 ? 1 : -1, w = std::abs(at(3, 2));  // view z = forward · distance
    const double clipUp = at(1, 1) > 0 ? 1 : -1;
    Lens lens{};
    lens.fx = 0.5 * widthPx * at(0, 0) / w, lens.cx = 0.5 * widthPx * (1 + forward * at(0, 2) / w);
    lens.fy = 0.5 * heightPx * std::abs(at(1, 1)) / w, lens.cy = 0.5 * heightPx * (1 - clipUp * forward * at(1, 2) / w);
    const double scale = forward * at(2, 2) / w, offset = at(2, 3) / w;
    if (clipDepth == DPL_CLIP_DEPTH_ZERO_TO_ONE) return ProjectionFacts{lens, float(scale), float(offset)};
    return ProjectionFacts{lens, float(0.5 * scale + 0.5), float(0.5 * offset)};
}

Status depthFromPlanes(float zAtZeroM, float zAtOneM, float* depth) {
    if (!depth) return fail(Code::InvalidArgument, "depth is NULL");
    if (!(zAtZeroM > 0) || !(zAtOneM > 0) || zAtZeroM == zAtOneM)
        return fail(Code::InvalidArgument, "depth from {} to {} m is empty or behind the camera", zAtZeroM, zAtOneM);
    const double atZero = 1 / double(zAtZeroM), atOne = 1 / double(zAtOneM);  // 0 at infinity
    depth[0] = float(-atZero / (atOne - atZero)), depth[1] = float(1 / (atOne - atZero));
    return {};
}

Status poseFromAxes(DplAxes axes, const float* orientation, const float* position, float* outOrientation, float* outPosition) {
    if (!outOrientation || !outPosition) return fail(Code::InvalidArgument, "an output is NULL");
    DPL_TRY(const Vec4d q, orientationOf(orientation));
    DPL_TRY(const Vec3d p, vectorOf(position, "position"));
    Vec4d turned;
    Vec3d moved;
    // A mirrored world turns the other way round: the axis of a rotation is mapped like a position, and then negated.
    switch (axes) {
        case DPL_AXES_OPENXR:
            turned = q, moved = p;
            break;
        case DPL_AXES_UNITY:
            turned = {-q.x, -q.y, q.z, q.w}, moved = {p.x, p.y, -p.z};
            break;
        case DPL_AXES_UNREAL:
            turned = {-q.y, -q.z, q.x, q.w}, moved = 0.01 * Vec3d(p.y, p.z, -p.x);
            break;
        default:
            return fail(Code::InvalidArgument, "there are no axes {}", int(axes));
    }
    for (int i = 0; i < 4; ++i) outOrientation[i] = float(turned[i]);
    for (int i = 0; i < 3; ++i) outPosition[i] = float(moved[i]);
    return {};
}

}  // namespace
}  // namespace dpl::api

using namespace dpl;
using namespace dpl::api;

extern "C" DplResult dplCameraLookAt(const float* eye, const float* target, const float* up, float fovYRad, uint32_t widthPx,
                                     uint32_t heightPx, DplCamera* camera) {
    return guarded("dplCameraLookAt", [&] { return cameraLookAt(eye, target, up, fovYRad, widthPx, heightPx, camera); });
}

extern "C" DplResult dplCameraFromAngles(const float* orientation, const float* position, const float* anglesRad, uint32_t widthPx,
                                         uint32_t heightPx, DplCamera* camera) {
    return guarded("dplCameraFromAngles", [&] { return cameraFromAngles(orientation, position, anglesRad, widthPx, heightPx, camera); });
}

extern "C" DplResult dplCameraFromProjection(const float* orientation, const float* position, const float* projection,
                                             DplClipDepth clipDepth, uint32_t widthPx, uint32_t heightPx, DplCamera* camera, float* depth) {
    return guarded("dplCameraFromProjection", [&]() -> Status {
        DPL_TRY(const ProjectionFacts facts, readProjection(projection, clipDepth, widthPx, heightPx));
        DPL_TRY(const Eye eye, eyeOf(orientation, position));
        DPL_RETURN_IF_ERROR(writeCamera(eye, facts.lens, widthPx, heightPx, camera));
        if (depth) depth[0] = facts.depthScale, depth[1] = facts.depthOffset;
        return {};
    });
}

extern "C" DplResult dplDepthFromPlanes(float zAtZeroM, float zAtOneM, float* depth) {
    return guarded("dplDepthFromPlanes", [&] { return depthFromPlanes(zAtZeroM, zAtOneM, depth); });
}

extern "C" DplResult dplPoseFromAxes(DplAxes axes, const float* orientation, const float* position, float* outOrientation,
                                     float* outPosition) {
    return guarded("dplPoseFromAxes", [&] { return poseFromAxes(axes, orientation, position, outOrientation, outPosition); });
}

extern "C" double dplSecondsBetween(int64_t startNs, int64_t timeNs) {
    // Whole seconds and the rest apart, because the difference of two timestamps may exceed 64 bits.
    constexpr int64_t kSecond = 1000000000;
    return double(timeNs / kSecond - startNs / kSecond) + double(timeNs % kSecond - startNs % kSecond) * 1e-9;
}
