// SPDX-License-Identifier: Apache-2.0
// Plain linear blend skinning in double precision: the truth of the scan, independent of the product's own skinning.
#pragma once

#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** A pose as in scan truth: one axis-angle triple a joint (radians), and the root's translation (metres), world +Y up. */
struct TruthPose {
    std::vector<Vec3d> rotations;
    Vec3d translation{0};
};

/** worldFromRest[j] = G_j (docs/formats/scan.md). */
std::vector<Mat3x4d> truthTransforms(const std::vector<JointData>& joints, const TruthPose& pose);

inline Vec3d transformed(const Mat3x4d& m, const Vec3d& p) {
    return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
}

/** One vertex with its four unorm8 weights. */
Vec3d skinned(const std::vector<Mat3x4d>& worldFromRest, const glm::u16vec4& joints, const glm::u8vec4& weights, const Vec3d& rest);

/** The blended matrix of one vertex. */
Mat3x4d blended(const std::vector<Mat3x4d>& worldFromRest, const glm::u16vec4& joints, const glm::u8vec4& weights);

}  // namespace dpl
