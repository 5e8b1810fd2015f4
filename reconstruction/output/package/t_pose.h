// SPDX-License-Identifier: Apache-2.0
// Lets an avatar rest with its arms stretched out sideways, as VRM demands.
#pragma once

#include "reconstruction/output/package/mesh_morphs.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Skins the mesh into a pose whose arms point sideways, and makes that the pose at rest: vertices and joints move, and joint frames are
 *  parallel to the world there. Legs stay as they rest. Clips, splats and correctives are of the old pose at rest, and are dropped. A rig
 *  without humanoid arms stays as it is. expressed: the mesh with expressions, which goes along. */
void restInTPose(AvatarData& avatar, std::span<ExpressedMesh> expressed, Jobs& jobs);

}  // namespace dpl
