// SPDX-License-Identifier: Apache-2.0
// Implicit shapes: the few smooth solids the procedural subject is modelled from. Negative inside, about metres outside.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** Union whose seam is rounded over about `k` metres (cubic polynomial blend; k = 0 is the plain union). */
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

/** First-order distance to an axis-parallel ellipsoid. */
inline float ellipsoid(const Vec3f& p, const Vec3f& centre, const Vec3f& radii) {
    const Vec3f q = (p - centre) / radii;
    const float k0 = glm::length(q), k1 = glm::length(q / radii);
    return k1 > 1e-6f ? k0 * (k0 - 1.0f) / k1 : -std::min({radii.x, radii.y, radii.z});
}

/** Capsule from a to b whose radius runs from ra to rb. */
inline float taperedCapsule(const Vec3f& p, const Vec3f& a, const Vec3f& b, float ra, float rb) {
    const Vec3f ab = b - a;
    const float t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0f, 1.0f);
    return glm::length(p - a - ab * t) - (ra + (rb - ra) * t);
}

/** One cross-section of a Tube, metres: where its centre sits beside the axis, and four quadrant radii. */
struct TubeStation {
    float s;  // along the axis from the origin
    float centreU = 0, centreV = 0;
    float radiusU = 0.01f;      // towards +u
    float radiusUBack = 0.01f;  // towards −u
    float radiusV = 0.01f;      // towards +v
    float radiusVBack = 0.01f;  // towards −v
};

/** A limb: cross-sections strung on a straight axis and interpolated by a Catmull-Rom curve. Each section is a superellipse of
 *  the given exponent (2: ellipse). Flat ends, meant to be hidden in a neighbour. */
class Tube {
public:
    Tube() = default;
    /** Axis from `origin` along `axis`; `u` is made perpendicular to it, v = axis × u. Stations rise in s. */
    Tube(const Vec3f& origin, const Vec3f& axis, const Vec3f& u, std::vector<TubeStation> stations, float exponent = 2.0f);

    float distance(const Vec3f& p) const;
    /** A lower bound of the distance that costs one length. */
    float bound(const Vec3f& p) const { return glm::length(p - boundCentre_) - boundRadius_; }

private:
    Vec3f origin_{0}, axis_{0, 1, 0}, u_{1, 0, 0}, v_{0, 0, 1}, boundCentre_{0};
    float boundRadius_ = 0, start_ = 0, length_ = 1, exponent_ = 2;
    std::vector<TubeStation> fine_;  // evenly spaced
};

}  // namespace dpl
