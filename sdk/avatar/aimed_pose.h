// SPDX-License-Identifier: Apache-2.0
// Poses made by pointing limbs somewhere, on any rig whose humanoid bones are known.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/humanoid.h"
#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** A limb that points somewhere: degrees outwards and forwards from straight down, in the frame of the body at rest. Left limbs are meant;
 *  their right twins take the mirrored direction. */
struct LimbAim {
    const char *bone, *next;  // the next bone down the limb
    float outDegrees = 0, forwardDegrees = 0;
    bool follows = false;  // the limb above it carries it; else the trunk
};

constexpr LimbAim thighAim(float forwardDegrees, float outDegrees = 5) {
    return {"UpperLeg", "LowerLeg", outDegrees, forwardDegrees};
}
constexpr LimbAim shankAim(float forwardDegrees) {
    return {"LowerLeg", "Foot", 5, forwardDegrees, true};
}
constexpr LimbAim armAim(float forwardDegrees, float outDegrees) {
    return {"UpperArm", "LowerArm", outDegrees, forwardDegrees};
}
constexpr LimbAim forearmAim(float forwardDegrees, float outDegrees) {
    return {"LowerArm", "Hand", outDegrees, forwardDegrees, true};
}

/** A pose: limbs of each side from the trunk outwards, those of the right side as if it were the left one, and a turn of the spine. */
struct AimedPose {
    std::vector<LimbAim> left, right;
    Vec3f spineDegrees{0};  // about x, y, z
};

/** Makes poses for one rig. `joints` must outlive it. */
class PoseAimer {
public:
    explicit PoseAimer(std::span<const JointData> joints) : joints_(joints), bones_(bonesOf(joints)) {}

    /** Whether the rig has hips and two upper legs. Limbs that it lacks stay at rest. */
    bool known() const;
    Pose pose(const AimedPose& aimed) const;

private:
    std::span<const JointData> joints_;
    BoneMap bones_;
};

}  // namespace dpl
