// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/surface_points.h"

#include <algorithm>

namespace dpl {

CarriedPoint::CarriedPoint(std::span<const JointData> joints, const MeshData& mesh, const MeshPoint& point) {
    const Triangle& t = mesh.triangles[point.triangle];
    const double corner[3] = {1.0 - point.uv.x - point.uv.y, point.uv.x, point.uv.y};
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 4; ++i) {
            const double weight = corner[c] * mesh.jointWeights[t[c]][i] / 255.0;
            if (weight == 0) continue;
            const uint32_t joint = mesh.jointIndices[t[c]][i];
            auto found = std::find_if(parts_.begin(), parts_.end(), [&](const Part& p) { return p.joint == joint; });
            if (found == parts_.end()) found = parts_.insert(parts_.end(), Part{joint, 0, Vec3d(0)});
            found->weight += weight;
            found->arm += weight * (Vec3d(mesh.restPositions[t[c]]) - Vec3d(joints[joint].restPosition));
        }
}

Vec3d CarriedPoint::place(const KeypointChain::Output& posed) const {
    Vec3d x(0);
    for (const Part& p : parts_) x += posed.rotations[p.joint] * p.arm + p.weight * posed.places[p.joint];
    return x;
}

void CarriedPoint::pull(const KeypointChain& chain, const KeypointChain::Output& posed, const Vec3d& gradient, double* row) const {
    for (const Part& p : parts_) {
        const Vec3d at = posed.rotations[p.joint] * p.arm + p.weight * posed.places[p.joint];
        for (int a = 0; a < 3; ++a) row[3 + a] += p.weight * gradient[a];
        for (int32_t j = int32_t(p.joint); j >= 0; j = chain.parent(size_t(j))) {
            const int32_t column = chain.columnOf(size_t(j));
            if (column < 0) continue;
            // ω turns the part about joint j: dX = ω × lever, so gradient · dX = ω · (lever × gradient).
            const Vec3d lever = at - p.weight * posed.places[size_t(j)];
            const Vec3d d = glm::cross(lever, gradient) * posed.turns[size_t(j)];  // turnᵀ (lever × gradient)
            for (int a = 0; a < 3; ++a) row[column + a] += d[a];
        }
    }
}

}  // namespace dpl
