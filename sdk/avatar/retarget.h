// SPDX-License-Identifier: Apache-2.0
// A motion of one skeleton onto another rig, by humanoid bone names.
//
// Both skeletons are described by how far every bone has turned in the world since its rest pose (D). Rest poses differ (T against
// A, straight against bent fingers), so each target bone k first gets a constant turn A_k that lays its rest direction onto
// the source bone's:   D_target = D_source · A_k.   Limb directions in the world then equal the source's exactly;
// torso, head, shoulders and feet use A = 1 (both stand upright at rest), which keeps the target's own build.
#pragma once

#include <span>

#include "sdk/avatar/motion.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct RetargetOptions {
    bool keepLeadIn = false;  // many BVH files blend from a rest pose within a few frames, faster than any body: dropped unless kept
    bool keepPlace = false;   // false: the hips start above where they stand at rest
    bool inPlace = false;     // no horizontal travel at all
    bool groundFeet = true;   // shifts the clip up or down so that the lowest foot stands as high as at rest
};

/** The motion on `target`: channels for the joints that both skeletons name, all others rest. Travel is scaled by the ratio of leg
 *  lengths. A bone that the source lacks follows its nearest mapped ancestor. Heading is turned so that the source's rest
 *  pose faces +Z, +Y up. Deterministic.
 *  Unsupported: fewer than hips, both upper legs or both upper arms in common; the text lists the source's joints.
 *  InvalidArgument: the target rig is not valid. CorruptData: the motion is not. */
Result<ClipData> retarget(const Motion& source, std::span<const JointData> target, const RetargetOptions& options = {});

}  // namespace dpl
