// SPDX-License-Identifier: Apache-2.0
// Takes the body in where no picture shows it and clothes sink into it, so that clothes stay outside when the avatar moves.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Vertices of the layer with the role "body" move inwards along their normals at rest, by as much as garments sink in there in the worst
 *  of `poses`, at most priors::kTuckM. Only vertices move of which every triangle is unseen; near seen skin and in thin parts they move
 * less. seen: one a triangle of the whole mesh. Garments, weights and correctives stay. Returns the number of vertices that moved; 0
 * without a body or a garment. The poses must have passed checkPose. Deterministic for any number of threads. */
size_t tuckBody(AvatarData& avatar, std::span<const uint8_t> seen, std::span<const Pose> poses, Jobs& jobs);

}  // namespace dpl
