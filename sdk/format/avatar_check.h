// SPDX-License-Identifier: Apache-2.0
// What an avatar must be before it is written, and the snapping that makes encoding idempotent. Internal.
#pragma once

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Array lengths, tiling of layers, joint order, weights, finiteness. The sentence names array and index. */
Status checkAvatar(const AvatarData& avatar);
/** All of it but the splats: coded ones are checked as they are read. */
Status checkAvatarWithoutSplats(const AvatarData& avatar);

/** The same avatar with vertices, joints and root translations on the lattice of kPositionStepM, unit clip rotations, and joint
 *  slots of weight 0 pointing at joint 0 (glTF wants that). Splats are left alone. Applying it twice changes nothing. */
void snapAvatar(AvatarData& avatar);

}  // namespace dpl
