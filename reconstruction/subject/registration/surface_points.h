// SPDX-License-Identifier: Apache-2.0
// Points of a skinned mesh, and how they move with the joints. Private to reconstruction/subject/registration.
#pragma once

#include <vector>

#include "reconstruction/subject/body/keypoint_chain.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** A material point: triangle and barycentric coordinates of corners 1 and 2. */
struct MeshPoint {
    uint32_t triangle = 0;
    Vec2f uv{0};
};

/** One point as its joints carry it: X = Σ_i W_i a_i + w_i P_i, with a in the rest frame of joint i. */
class CarriedPoint {
public:
    CarriedPoint(std::span<const JointData> joints, const MeshData& mesh, const MeshPoint& point);

    /** Place in the world, metres. */
    Vec3d place(const KeypointChain::Output& posed) const;
    /** Adds gradientᵀ · dX/d(root, pose) to `row`, which has chain.columns() entries. `posed` must hold turns. */
    void pull(const KeypointChain& chain, const KeypointChain::Output& posed, const Vec3d& gradient, double* row) const;

private:
    struct Part {
        uint32_t joint = 0;
        double weight = 0;
        Vec3d arm{0};
    };
    std::vector<Part> parts_;
};

}  // namespace dpl
