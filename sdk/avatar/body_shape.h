// SPDX-License-Identifier: Apache-2.0
// How wide an avatar's trunk and thighs are, so that arms can be kept out of them. Formulas: docs/reference/driving.md.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sdk/avatar/body_tube.h"
#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

class BodyShape {
public:
    /** Measures the mesh at rest: clothes count. Empty if the rig has no hips, or the mesh does not surround it. */
    static BodyShape of(std::span<const JointData> joints, const MeshData& mesh);

    bool empty() const { return tubes_.empty(); }

    /** What lies inside the body: by how far, metres, and the way out, unit, in the world. */
    struct Inside {
        float depthM = 0;
        Vec3f outward{0};
    };
    /** The deepest place of a ball in the posed body; none if it touches nothing. worldFromRest: jointTransforms of the pose. */
    std::optional<Inside> inside(const Vec3f& centre, float radiusM, std::span<const Mat3x4f> worldFromRest) const;

    /** Half of the thickness of the hand, and the radii of the lower and the upper arm, metres. side: 0 left, 1 right. */
    float handM(size_t side) const { return handM_[side]; }
    float lowerArmM(size_t side) const { return lowerArmM_[side]; }
    float upperArmM(size_t side) const { return upperArmM_[side]; }

private:
    std::vector<BodyTube> tubes_;
    float handM_[2] = {0.015f, 0.015f}, lowerArmM_[2] = {0.04f, 0.04f}, upperArmM_[2] = {0.05f, 0.05f};
};

}  // namespace dpl
