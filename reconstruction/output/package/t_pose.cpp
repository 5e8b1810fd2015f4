// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/t_pose.h"

#include "sdk/avatar/aimed_pose.h"
#include "sdk/avatar/rig.h"

namespace dpl {

void restInTPose(AvatarData& avatar, std::span<ExpressedMesh> expressed, Jobs& jobs) {
    const std::vector<LimbAim> arm = {armAim(0, 90), forearmAim(0, 90), {"Hand", "MiddleProximal", 90, 0, /*follows=*/true}};
    const Pose pose = PoseAimer(avatar.joints).pose({arm, arm});
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(avatar.joints, pose, worldFromRest);
    const auto move = [&](std::vector<Vec3f>& positions) {
        std::vector<Vec3f> moved;
        skin(avatar.mesh, positions, worldFromRest, jobs, moved);
        positions = std::move(moved);
    };
    move(avatar.mesh.restPositions);
    for (ExpressedMesh& shape : expressed) move(shape.positions);
    for (size_t j = 0; j < avatar.joints.size(); ++j)
        avatar.joints[j].restPosition = worldFromRest[j] * Vec4f(avatar.joints[j].restPosition, 1);
    avatar.clips.clear(), avatar.splats = {}, avatar.correctives = {}, avatar.expressions = {};
}

}  // namespace dpl
