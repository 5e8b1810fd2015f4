// SPDX-License-Identifier: Apache-2.0
// How well registration knows the pose of one frame.
#pragma once

#include <cstdint>
#include <vector>

namespace dpl {

/** The precision matrix JᵀJ of a frame's registered pose, all other frames held: ½ dᵀ·matrix·d is what a deviation d costs, in nats.
 *  d: for each of `joints` the left turn in its parent's frame (R = exp(turn)·R_registered), rad, then the root's translation, metres. */
struct PosePrecision {
    std::vector<uint32_t> joints;  // that may turn, ascending; the root is the first
    std::vector<double> matrix;    // size() × size(), symmetric

    size_t size() const { return 3 * joints.size() + 3; }
};

/** What two independent observations of one pose say together: the sum of their matrices, over the joints of either. Both have the root. */
PosePrecision together(const PosePrecision& a, const PosePrecision& b);

}  // namespace dpl
