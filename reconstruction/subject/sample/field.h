// SPDX-License-Identifier: Apache-2.0
// Implicit solids from which the procedural subject is modelled. Values are approximate signed distances in metres, negative inside.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** 0 at `from`, 1 at `to`, smooth between and constant beyond (smoothstep). from may be above to. */
inline float ramp(float x, float from, float to) {
    const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

/** Union whose seam is rounded over about `k` metres (cubic polynomial blend). k = 0 is the plain union. */
inline float smoothUnion(float a, float b, float k) {
    if (k <= 0) return std::min(a, b);
    const float h = std::max(k - std::abs(a - b), 0.0f) / k;
    return std::min(a, b) - h * h * h * k * (1.0f / 6.0f);
}
inline float smoothIntersection(float a, float b, float k) {
    return -smoothUnion(-a, -b, k);
}
/** `a` without `b`. */
inline float smoothDifference(float a, float b, float k) {
    return smoothIntersection(a, -b, k);
}

/** Distance to an axis-parallel ellipsoid, first-order approximation. */
inline float ellipsoid(const Vec3f& p, const Vec3f& centre, const Vec3f& radii) {
    const Vec3f q = (p - centre) / radii;
    const float k0 = glm::length(q), k1 = glm::length(q / radii);
    return k1 > 1e-6f ? k0 * (k0 - 1.0f) / k1 : -std::min({radii.x, radii.y, radii.z});
}

/** Capsule from a to b with a radius that changes linearly from ra to rb. */
inline float taperedCapsule(const Vec3f& p, const Vec3f& a, const Vec3f& b, float ra, float rb) {
    const Vec3f ab = b - a;
    const float t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0f, 1.0f);
    return glm::length(p - a - ab * t) - (ra + (rb - ra) * t);
}

/** One cross-section of a Tube, metres: the offset of its centre from the axis, and its radius in four directions. */
struct TubeStation {
    float s;  // position along the axis, from the origin
    float centreU = 0, centreV = 0;
    float radiusU = 0.01f;      // towards +u
    float radiusUBack = 0.01f;  // towards −u
    float radiusV = 0.01f;      // towards +v
    float radiusVBack = 0.01f;  // towards −v
};

/** A limb: cross-sections along a straight axis, interpolated by a Catmull-Rom curve. Each section is a superellipse of the given
 *  exponent (2: ellipse). The ends are flat; place them inside a neighbouring solid. */
class Tube {
public:
    Tube() = default;
    /** `axis` and `u` need not be unit vectors; `u` is made perpendicular to the axis, v = axis × u. Stations are sorted by s. */
    Tube(const Vec3f& origin, const Vec3f& axis, const Vec3f& u, std::vector<TubeStation> stations, float exponent = 2.0f);

    float distance(const Vec3f& p) const;
    /** A cheap lower bound of the distance, from a bounding sphere. */
    float bound(const Vec3f& p) const { return glm::length(p - boundCentre_) - boundRadius_; }

private:
    Vec3f origin_{0}, axis_{0, 1, 0}, u_{1, 0, 0}, v_{0, 0, 1}, boundCentre_{0};
    float boundRadius_ = 0, start_ = 0, length_ = 1, exponent_ = 2;
    std::vector<TubeStation> fine_;  // stations resampled at even spacing
};

}  // namespace dpl
