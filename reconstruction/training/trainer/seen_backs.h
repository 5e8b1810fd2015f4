// SPDX-License-Identifier: Apache-2.0
// Which triangles of garments show their back: the far wall of a skirt, seen under its hem.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"

namespace dpl {

/** 1 for each triangle of the layers above the body that turns its back to the eye in front of everything else, in one of the poses and one
 *  of 16 views around it. All 0 for a mesh without layers: a closed skin hides its backs. */
std::vector<uint8_t> seenBacks(std::span<const JointData> joints, const MeshData& mesh, std::span<const Pose> poses, Jobs& jobs);

}  // namespace dpl
