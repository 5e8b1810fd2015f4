// SPDX-License-Identifier: Apache-2.0
// Arithmetic of XrPosef. Internal to this room and to programs that place things in its world.
#pragma once

#include <cmath>

#include "platform/openxr/openxr.h"

namespace dpl::xr {

constexpr XrPosef kIdentityPose{{0, 0, 0, 1}, {0, 0, 0}};

/** Makes the orientation one of length 1. False: the pose is not finite, or the orientation is off by more than OpenXR's 1 %. */
inline bool makeValid(XrPosef& pose) {
    XrQuaternionf& q = pose.orientation;
    const float length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    const XrVector3f& p = pose.position;
    if (!(std::abs(length - 1) <= 0.01f) || !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return false;
    q.x /= length, q.y /= length, q.z /= length, q.w /= length;
    return true;
}

inline XrQuaternionf operator*(const XrQuaternionf& a, const XrQuaternionf& b) {
    return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

constexpr XrQuaternionf conjugate(const XrQuaternionf& q) {
    return {-q.x, -q.y, -q.z, q.w};
}

/** A part (0 to 1) of a rotation, the short way round. */
inline XrQuaternionf partOf(const XrQuaternionf& q, float part) {
    const float sign = q.w < 0 ? -1.0f : 1.0f, sine = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
    if (sine < 1e-6f) return {0, 0, 0, 1};
    const float half = std::atan2(sine, sign * q.w) * part, scale = sign * std::sin(half) / sine;
    return {scale * q.x, scale * q.y, scale * q.z, std::cos(half)};
}

inline XrVector3f rotate(const XrQuaternionf& q, const XrVector3f& v) {
    const XrQuaternionf r = q * XrQuaternionf{v.x, v.y, v.z, 0} * conjugate(q);
    return {r.x, r.y, r.z};
}

/** aFromB * bFromC is aFromC. */
inline XrPosef operator*(const XrPosef& a, const XrPosef& b) {
    const XrVector3f p = rotate(a.orientation, b.position);
    return {a.orientation * b.orientation, {p.x + a.position.x, p.y + a.position.y, p.z + a.position.z}};
}

inline XrPosef inverse(const XrPosef& pose) {
    const XrQuaternionf back = conjugate(pose.orientation);
    const XrVector3f p = rotate(back, pose.position);
    return {back, {-p.x, -p.y, -p.z}};
}

}  // namespace dpl::xr
