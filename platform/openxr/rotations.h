// SPDX-License-Identifier: Apache-2.0
// Directions and rotations between them. Internal to this room.
#pragma once

#include "platform/openxr/poses.h"

namespace dpl::xr {

inline XrVector3f operator+(const XrVector3f& a, const XrVector3f& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline XrVector3f operator-(const XrVector3f& a, const XrVector3f& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline XrVector3f operator*(float s, const XrVector3f& v) {
    return {s * v.x, s * v.y, s * v.z};
}
inline float dot(const XrVector3f& a, const XrVector3f& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline XrVector3f cross(const XrVector3f& a, const XrVector3f& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(const XrVector3f& v) {
    return std::sqrt(dot(v, v));
}
/** Of length 1; `otherwise` if v is almost zero. */
inline XrVector3f normalised(const XrVector3f& v, const XrVector3f& otherwise = {0, 0, 0}) {
    const float l = length(v);
    return l > 1e-6f ? (1 / l) * v : otherwise;
}
inline XrQuaternionf normalised(const XrQuaternionf& q) {
    const float l = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return l > 1e-6f ? XrQuaternionf{q.x / l, q.y / l, q.z / l, q.w / l} : XrQuaternionf{0, 0, 0, 1};
}

/** The smallest rotation that turns one unit vector to another; opposite ones by a half turn about any axis across. */
inline XrQuaternionf between(const XrVector3f& from, const XrVector3f& to) {
    const float d = dot(from, to);
    if (d < -0.99999f) {
        const XrVector3f other = std::abs(from.x) < 0.7f ? XrVector3f{1, 0, 0} : XrVector3f{0, 1, 0};
        const XrVector3f axis = normalised(cross(from, other));
        return {axis.x, axis.y, axis.z, 0};
    }
    const XrVector3f axis = cross(from, to);
    return normalised(XrQuaternionf{axis.x, axis.y, axis.z, 1 + d});
}

/** A part (0 to 1) of a rotation, the short way round. */
inline XrQuaternionf partOf(const XrQuaternionf& q, float part) {
    const float sign = q.w < 0 ? -1.0f : 1.0f, sine = length({q.x, q.y, q.z});
    if (sine < 1e-6f) return {0, 0, 0, 1};
    const float half = std::atan2(sine, sign * q.w) * part, scale = sign * std::sin(half) / sine;
    return {scale * q.x, scale * q.y, scale * q.z, std::cos(half)};
}

/** The rotation whose columns are these axes: unit, at right angles, right-handed. */
inline XrQuaternionf fromAxes(const XrVector3f& x, const XrVector3f& y, const XrVector3f& z) {
    // The largest of four ways to write it, so that nothing is divided by almost zero.
    const float w2 = 1 + x.x + y.y + z.z, x2 = 1 + x.x - y.y - z.z, y2 = 1 - x.x + y.y - z.z, z2 = 1 - x.x - y.y + z.z;
    if (w2 >= x2 && w2 >= y2 && w2 >= z2) return normalised(XrQuaternionf{y.z - z.y, z.x - x.z, x.y - y.x, w2});
    if (x2 >= y2 && x2 >= z2) return normalised(XrQuaternionf{x2, y.x + x.y, z.x + x.z, y.z - z.y});
    if (y2 >= z2) return normalised(XrQuaternionf{y.x + x.y, y2, z.y + y.z, z.x - x.z});
    return normalised(XrQuaternionf{z.x + x.z, z.y + y.z, z2, x.y - y.x});
}

}  // namespace dpl::xr
