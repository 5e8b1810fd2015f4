// SPDX-License-Identifier: Apache-2.0
// Checks an avatar before it is written, and snaps it to values that the file stores exactly. Internal.
#pragma once

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Checks array lengths, tiling of layers, joint order, weights and that numbers are finite. The error names array and index. */
Status checkAvatar(const AvatarData& avatar);
/** The same without the splats; coded splats are checked while they are read. */
Status checkAvatarWithoutSplats(const AvatarData& avatar);

/** Rounds vertices, joints and root translations to multiples of kPositionStepM, normalises the rotations of clips, and points joint
 *  slots of weight 0 at joint 0 as glTF demands. Splats do not change. Applying it twice changes nothing more. */
void snapAvatar(AvatarData& avatar);

}  // namespace dpl
