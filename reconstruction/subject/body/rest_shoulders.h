// SPDX-License-Identifier: Apache-2.0
// The rest pose of a person's shoulders. A template's collarbones are as high as its author made them; people's hang lower or higher. The
// fit makes up for that by turning them, by about 20° on the built-in body. Clips and trackers turn collarbones little or not at all, so
// an avatar whose rest pose has them too high walks with padded shoulders (docs/reference/registration.md).
#pragma once

#include "reconstruction/subject/body/fit_body.h"

namespace dpl {

/** Makes the shoulders (humanoid leftShoulder and rightShoulder) of fit.staticPose those of the rest pose. Arms keep their direction at
 *  rest, because lower arms would crowd the armpits. Joints and vertices of `shaped` move to where these turns take them. Poses and
 *  landmark offsets of `fit` are rewritten for the new rest pose, so that every bone stays where it was:
 *      R'_j = C_parent R_j C_jᵀ,   C_j: world rotation of joint j when these turns alone are made
 *  The morphs are not turned, so `shaped` must have its final shape. A body without shoulders stays as it is. */
void restShouldersAsScanned(BodyModel& shaped, BodyFit& fit);

}  // namespace dpl
