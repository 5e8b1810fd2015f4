// SPDX-License-Identifier: Apache-2.0
// Recognises limbs and head of a person by the shape of a skeleton: two long pairs of branches, and lengths that tell knees and elbows.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** Humanoid bones by joint: upper legs to toes, shoulders to hands, and the head; empty for other joints. Bone lengths are those of
 *  restPosition. sides: by joint, +1 left, -1 right, 0 not known. Where these tell nothing, `at` does: positions in a pose in which the
 * person stands, in one of which the toes point ahead; without toes, y-up skeletons face +z and z-up ones -y. Empty: no person with four
 * limbs. */
std::optional<std::vector<std::string>> limbsByShape(std::span<const JointData> joints, std::span<const Vec3f> at,
                                                     std::span<const int> sides);

}  // namespace dpl
