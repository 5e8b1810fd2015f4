// SPDX-License-Identifier: Apache-2.0
// What both renderers require of a subject before they load it. Avatars from files have passed stricter checks; avatars built in memory
// come here unchecked. Limits of a device are checked by its renderer.
#pragma once

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** All of an avatar but its splats: rig, mesh and pose correctives. InvalidArgument names what does not fit. */
Status checkAvatarPosable(const AvatarData& avatar);

/** Splats bound to the avatar's triangles: arrays of one length, covered by triangleStart. InvalidArgument; Unsupported for an SH degree
 * above kMaxShDegree. */
Status checkBoundSplats(const AvatarData& avatar);

/** The same for general splats. */
Status checkGeneralSplats(const StaticSplatData& splats);

}  // namespace dpl
