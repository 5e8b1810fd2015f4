// SPDX-License-Identifier: Apache-2.0
// Checks a subject for both renderers before they load it. Avatars from files have passed stricter checks; avatars built in memory come
// here unchecked. Each renderer checks the limits of its device itself.
#pragma once

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Checks rig, mesh, pose correctives and light of an avatar, but not its splats. InvalidArgument names what does not fit. */
Status checkAvatarPosable(const AvatarData& avatar);

/** Checks avatar.splats: arrays of one length, and a triangleStart that covers triangles and splats. InvalidArgument; Unsupported for an SH
 * degree above kMaxShDegree. */
Status checkBoundSplats(const AvatarData& avatar);

/** Checks general splats: arrays of one length. The same errors. */
Status checkGeneralSplats(const StaticSplatData& splats);

}  // namespace dpl
