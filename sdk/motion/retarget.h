// SPDX-License-Identifier: Apache-2.0
// Transfers the motion of one skeleton to another rig by humanoid bone names.
//
// Directions are exact (bone_follower.h).
// What then still looks wrong is corrected last, by options: heads that do not look ahead, feet that slide, arms in the trunk.
#pragma once

#include <span>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/motion/arm_guard.h"
#include "sdk/motion/motion.h"

namespace dpl {

struct RetargetOptions {
    bool keepLeadIn = false;          // keeps the frames in which many BVH files blend from a rest pose, faster than a body can move
    bool keepPlace = false;           // false: the clip starts with the hips above their place at rest
    bool inPlace = false;             // no horizontal travel at all
    bool groundFeet = true;           // shifts the clip vertically so that the lowest foot is as high as at rest
    bool levelHead = true;            // turns the head by a constant, so that people who walk or run look ahead
    bool plantFeet = true;            // holds feet in place while they stand (plant_feet.h)
    const BodyShape* body = nullptr;  // of the target: arms are kept out of it; null: they are not
    std::vector<std::string>* notes = nullptr;  // gets sentences: limbs that nothing drives, a rest pose that had to be made
};

/** The motion as a clip on `target`. It has channels for the bones that both skeletons have. Other joints keep their local rest rotation,
 *  so they follow their nearest mapped ancestor. The motion is turned so that the source's rest pose (standing_rest.h) faces +Z with +Y up.
 * Travel is scaled by the ratio of leg lengths. Deterministic. Unsupported: the skeletons do not share the hips and both upper legs or both
 * upper arms; the text lists the joints of the skeleton that lacks them. InvalidArgument: the target rig is not valid. CorruptData: the
 * motion is not valid. */
Result<ClipData> retarget(const Motion& source, std::span<const JointData> target, const RetargetOptions& options = {});

}  // namespace dpl
