// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/pose_blend.h"

#include <algorithm>

#include "platform/openxr/rotations.h"

namespace dpl::xr {

void PoseBlend::step(std::span<XrQuaternionf> rotations, std::span<const uint8_t> driven, float stepS) {
    for (size_t j = 0; j < joints_.size(); ++j) {
        Joint& joint = joints_[j];
        joint.leftS = std::max(0.0f, joint.leftS - stepS);
        if (!first_ && joint.driver != driven[j]) {
            joint.offset = joint.shown * conjugate(rotations[j]);
            joint.leftS = kPoseBlendS;
        }
        joint.driver = driven[j];
        const float left = joint.leftS / kPoseBlendS;
        if (left > 0) rotations[j] = normalised(partOf(joint.offset, left * left * (3 - 2 * left)) * rotations[j]);
        joint.shown = rotations[j];
    }
    first_ = false;
}

}  // namespace dpl::xr
