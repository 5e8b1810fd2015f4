// SPDX-License-Identifier: Apache-2.0
// Poses of a synthetic scan and skinning in double precision: the truth that reconstructions are compared with. Joint transforms are
// computed from axis-angle rotations, independently of the rig in sdk/avatar.
#pragma once

#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/skinning.h"

namespace dpl {

/** A pose as in scan truth: one axis-angle rotation per joint (radians) and the root's translation (metres). World +Y up. */
struct TruthPose {
    std::vector<Vec3d> rotations;
    Vec3d translation{0};
};

/** The same pose as the SDK poses it. */
Pose poseOf(const TruthPose& pose);

/** worldFromRest of each joint: G_j of docs/formats/scan.md. */
std::vector<Mat3x4d> truthTransforms(const std::vector<JointData>& joints, const TruthPose& pose);

/** Skins one vertex with its four unorm8 weights. */
inline Vec3d skinned(const std::vector<Mat3x4d>& worldFromRest, const glm::u16vec4& joints, const glm::u8vec4& weights, const Vec3d& rest) {
    return transformed(blendedTransform(joints, weights, worldFromRest.data()), rest);
}

}  // namespace dpl
