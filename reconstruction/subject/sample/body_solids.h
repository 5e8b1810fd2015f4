// SPDX-License-Identifier: Apache-2.0
// How far a point is from the subject's head, dressed trunk and upper arms in any pose: what hair that swings stays out of.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "reconstruction/subject/shape/closest_surface.h"
#include "sdk/core/jobs.h"
#include "sdk/math/types.h"

namespace dpl {

struct Subject;

/** Signed distances in a box, on a grid that is interpolated linearly. */
class DistanceGrid {
public:
    /** `distance` is called for each grid point on several threads. Distances are cut to ±reachM. */
    DistanceGrid(const Vec3f& low, const Vec3f& high, float stepM, float reachM, const std::function<float(const Vec3f&)>& distance,
                 Jobs& jobs);
    /** The distance and its gradient. Outside of the box: the reach, and no gradient. */
    double at(const Vec3d& p, Vec3d& gradient) const;

private:
    Vec3d low_;
    double stepM_, reachM_;
    glm::ivec3 count_{0};
    std::vector<float> values_;
};

/** The solids of a standing subject. */
class BodySolids {
public:
    /** About a second. Same bytes for any thread count. */
    BodySolids(const Subject& subject, Jobs& jobs);

    static constexpr double kReachM = 0.06;  // distances are exact up to here

private:
    friend class PosedSolids;
    BodySolids(const Subject& subject, const ClosestSurface& skin, Jobs& jobs);
    DistanceGrid head_, trunk_;                       // the head with the space before the face, the trunk with its shirt
    std::array<std::array<Vec3d, 2>, 2> upperArms_;   // ends
    std::array<double, 2> armRadiusM_{0.055, 0.045};  // at the shoulder and at the elbow
};

/** The solids in a pose: head and trunk are stiff. The BodySolids must outlive it. */
class PosedSolids {
public:
    PosedSolids(const BodySolids& solids, const std::vector<Mat3x4d>& worldFromRest);

    struct Near {
        double distanceM = 0;  // negative inside
        Vec3d outward{0};      // unit; zero beyond the reach
    };
    Near nearest(const Vec3d& p) const;

private:
    const BodySolids& solids_;
    Mat3x4d head_, trunk_;  // worldFromRest
    std::array<std::array<Vec3d, 2>, 2> upperArms_;
};

}  // namespace dpl
