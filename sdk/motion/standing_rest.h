// SPDX-License-Identifier: Apache-2.0
// The pose of a recorded skeleton from which rotations count: standing upright, facing +Z.
#pragma once

#include <string>
#include <vector>

#include "sdk/avatar/humanoid.h"
#include "sdk/motion/motion.h"

namespace dpl {

/** D of bone_follower.h at a key is upright · R · inverse · upright⁻¹, where R is the joint's world rotation in motionAt(). */
struct StandingRest {
    BoneMap bones;               // of the motion
    std::vector<Vec3f> at;       // joints, upright
    std::vector<Quatf> inverse;  // by joint
    Quatf upright{1, 0, 0, 0};   // turns up and forward of the file to +Y and +Z
    std::string note;            // where another pose than the file's rest pose is used: a sentence that says so
};

/** The file's rest pose if it stands. Else one is made from the frame that stands best, whichever it is: trunk and limbs are turned to
 * those of a T-pose by their directions; a neck is as straight as it is on average. Forward is then +z of files with y up, -y of files with
 * z up. Without the bones to tell how it stands: the first frame. */
StandingRest standingRest(const Motion& motion);

}  // namespace dpl
