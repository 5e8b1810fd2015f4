// SPDX-License-Identifier: Apache-2.0
// Rigid transforms. aFromC = compose(aFromB, bFromC).
#pragma once

#include <openxr/openxr.h>

namespace dpl::mockxr {

constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};

inline XrVector3f cross(XrVector3f a, XrVector3f b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline XrVector3f rotate(XrQuaternionf q, XrVector3f v) {
    const XrVector3f axis{q.x, q.y, q.z}, t = cross(axis, v), u = cross(axis, t);
    return {v.x + 2 * (q.w * t.x + u.x), v.y + 2 * (q.w * t.y + u.y), v.z + 2 * (q.w * t.z + u.z)};
}
inline XrQuaternionf multiply(XrQuaternionf a, XrQuaternionf b) {
    return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
inline XrPosef compose(const XrPosef& a, const XrPosef& b) {
    const XrVector3f moved = rotate(a.orientation, b.position);
    return {multiply(a.orientation, b.orientation), {a.position.x + moved.x, a.position.y + moved.y, a.position.z + moved.z}};
}
inline XrPosef inverse(const XrPosef& a) {
    const XrQuaternionf q{-a.orientation.x, -a.orientation.y, -a.orientation.z, a.orientation.w};
    const XrVector3f p = rotate(q, a.position);
    return {q, {-p.x, -p.y, -p.z}};
}
/** The local space of a pose, moved down to the floor. */
inline XrPosef onFloor(XrPosef worldFromLocal) {
    worldFromLocal.position.y = 0;
    return worldFromLocal;
}

}  // namespace dpl::mockxr
