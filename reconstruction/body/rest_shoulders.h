// SPDX-License-Identifier: Apache-2.0
// The rest pose of a person's shoulders. A template's collarbones are as high as its author made them; people's hang lower or higher. The
// fit makes up for that by turning them, by about 20° on the built-in body. Clips and trackers turn collarbones little or not at all, so
// an avatar whose rest pose has them too high walks with padded shoulders (ADR 0076).
#pragma once

#include "reconstruction/body/fit_body.h"

namespace dpl {

/** Makes the shoulders (humanoid leftShoulder and rightShoulder) of fit.staticPose those of the rest pose. Arms keep their
 *  direction: in lower ones armpits would be crowded at rest. Joints and vertices of `shaped` move to where these turns take them. Poses
 * and landmark offsets of `fit` are rewritten for the new rest pose, so every bone stays where it was:  R'_j = C_parent R_j C_jᵀ,  with C_j
 * the world rotation of joint j when these alone turn. `shaped` has its final shape: its morphs are not turned. A body without shoulders
 * stays as it is. */
void restShouldersAsScanned(BodyModel& shaped, BodyFit& fit);

}  // namespace dpl
