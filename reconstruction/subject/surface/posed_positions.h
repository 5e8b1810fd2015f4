// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"

namespace dpl {

/** The vertices of a mesh in a pose, world space. */
inline void posedPositions(std::span<const JointData> joints, const MeshData& mesh, const Pose& pose, Jobs& jobs,
                           std::vector<Vec3f>& positions) {
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(joints, pose, worldFromRest);
    skin(mesh, worldFromRest, jobs, positions);
}

}  // namespace dpl
