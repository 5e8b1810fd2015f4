// SPDX-License-Identifier: Apache-2.0
// Keeps the motion modes of a training run from tearing clothes in poses that it did not see. docs/reference/correctives.md, "Motion modes"
#pragma once

#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** A node hears only the groups that reach its clothes (motionReachingNodes): no skin, hair or shoes move. Two neighbouring nodes differ by
 * a share of their distance at most, so the strain of a sum is bounded by the lengths of its coefficients, in every pose. Brightness is not
 * bounded. */
class MotionBounds {
public:
    MotionBounds(std::span<const JointData> joints, const MeshData& mesh, const PoseCorrectiveData& correctives);

    /** One sweep over the neighbours, in a fixed order. Offsets of groups that a node does not hear become 0. Correctives: those of the
     * constructor. */
    void apply(PoseCorrectiveData& correctives) const;

private:
    struct Neighbours {
        uint32_t a, b;
        float distanceM;
    };
    std::vector<uint32_t> heard_;  // a node: bits of the groups that it hears
    std::vector<Neighbours> neighbours_;
};

}  // namespace dpl
