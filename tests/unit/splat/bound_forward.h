// SPDX-License-Identifier: Apache-2.0
// Projects one bound splat with the scalar formulas of sdk/math, in float or double: the counterpart of the SIMD kernel of sdk/splat.
#pragma once

#include "sdk/math/binding.h"
#include "sdk/math/projection.h"
#include "sdk/math/sh.h"
#include "sdk/splat/forward_record.h"

namespace dpl::test {

template <class T>
struct BoundSplat {
    Vec2<T> uv{0};
    T phi = 0;
    Vec2<T> scaleM{0};
    T opacity = 0;
    bool singleFace = false;
    uint32_t shDegree = 0;
    const T* sh = nullptr;  // coefficient-major
};

template <class T>
struct BoundForward {
    Vec2<T> centrePx{0};
    T opacity = 0;
    Vec3<T> colour{0};
    bool visible = false;
    ForwardRecord<T> record{};
};

template <class T>
BoundForward<T> projectBoundSplat(const PinholeCamera<T>& camera, const TriangleFrame<T>& frame, const BoundSplat<T>& splat, T kappaPx2) {
    using F = Formulas<T>;
    const Lens<T> lens = lensOf(camera);
    const Mat3<T>& turn = camera.viewFromWorldRotation;
    const Vec3<T> centre = splatCentre(frame, splat.uv), toEye = camera.eye() - centre, view = camera.toView(centre);
    const auto a = F::planeAxes(std::cos(splat.phi), std::sin(splat.phi), splat.scaleM.x, splat.scaleM.y);
    const Vec3<T> axis1 = turn * (a.a10 * frame.f0 + a.a11 * frame.f1), axis2 = turn * (a.a20 * frame.f0 + a.a21 * frame.f1);
    const auto j = F::jacobianAt(lens, view);
    const Vec2<T> b1 = F::axisOnScreen(j, axis1), b2 = F::axisOnScreen(j, axis2);
    const Footprint<T> f = F::footprintOf(lens, j, view.z, F::flatSpread(b1, b2), kappaPx2);

    BoundForward<T> out;
    ForwardRecord<T>& r = out.record;
    r.a10 = a.a10, r.a11 = a.a11, r.a20 = a.a20, r.a21 = a.a21;
    r.b1X = b1.x, r.b1Y = b1.y, r.b2X = b2.x, r.b2Y = b2.y;
    r.slopeX = j.slope.x, r.slopeY = j.slope.y, r.clampedX = j.clampedSlope.x, r.clampedY = j.clampedSlope.y;
    r.depthM = view.z, r.inverseZ = j.inverseZ, r.axis1Z = axis1.z, r.axis2Z = axis2.z;
    r.conicA = f.conicA, r.conicB = f.conicB, r.conicC = f.conicC, r.inverseDet = f.inverseDet;
    r.compensation = f.compensation, r.nearFade = nearFade(view.z);
    r.inverseDistance = T(1) / glm::length(toEye), r.cosine = glm::dot(frame.normal, toEye) * r.inverseDistance;
    r.gate = (splat.singleFace ? singleFaceGate(frame.normal, centre, camera.eye()) : T(1)) * frame.shown;
    const Vec3<T> direction = glm::transpose(frame.worldFromRest) * (-toEye * r.inverseDistance);
    r.directionX = direction.x, r.directionY = direction.y, r.directionZ = direction.z;
    T basis[kMaxShCoefficients];
    shBasis(direction, splat.shDegree, basis);
    Vec3<T> unlit(T(0.5));
    for (uint32_t k = 0; k < shCoefficientCount(splat.shDegree); ++k)
        unlit += basis[k] * Vec3<T>(splat.sh[k * 3], splat.sh[k * 3 + 1], splat.sh[k * 3 + 2]);
    r.red = unlit.x, r.green = unlit.y, r.blue = unlit.z, r.light = splatLight(frame, splat.uv);

    out.centrePx = f.centrePx;
    out.opacity = splat.opacity * r.compensation * r.nearFade * r.gate;
    out.colour = glm::clamp(unlit * r.light, T(0), T(1));
    out.visible = frame.valid && f.visible;
    return out;
}

}  // namespace dpl::test
