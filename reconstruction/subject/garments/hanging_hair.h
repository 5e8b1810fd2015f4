// SPDX-License-Identifier: Apache-2.0
// Skin weights of hair that hangs. It lies over neck, shoulders and chest, but it is rooted on the head and turns with that.
// docs/reference/garments.md, "Weights"
#pragma once

#include <span>

#include "reconstruction/subject/garments/cloth_weights.h"

namespace dpl {

/** Gives hair that hangs below the ears the head's weight instead of that of the body below: all of it down to kHairFollowsHeadM, none from
 *  kHairFollowsBodyM on. Leaves hair alone that ends above the chin, and rigs without a head. piece: in the pose of worldFromRest, which
 *  has a transform for every joint. Weights still sum to 255. */
void hangFromHead(const SurfaceMesh& piece, std::span<const JointData> joints, std::span<const Mat3x4f> worldFromRest,
                  ClothWeights& weights);

}  // namespace dpl
