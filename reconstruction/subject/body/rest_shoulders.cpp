// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/rest_shoulders.h"

#include "reconstruction/subject/body/body_tools.h"
#include "sdk/math/skinning.h"

namespace dpl {

void restShouldersAsScanned(BodyModel& shaped, BodyFit& fit) {
    const size_t jointCount = shaped.joints.size();
    Pose turned = Pose::rest(jointCount);
    for (const std::string side : {"left", "right"}) {
        const int32_t shoulder = findHumanoid(shaped, side + "Shoulder"), arm = findHumanoid(shaped, side + "UpperArm");
        if (shoulder < 0) continue;
        const Quatf turn = glm::normalize(fit.staticPose.localRotations[size_t(shoulder)]);
        turned.localRotations[size_t(shoulder)] = turn;
        if (arm >= 0 && shaped.joints[size_t(arm)].parent == shoulder) turned.localRotations[size_t(arm)] = glm::conjugate(turn);
    }
    std::vector<Mat3x4f> moved;  // to the new rest pose from the old one
    jointTransforms(shaped.joints, turned, moved);

    std::vector<Quatf> world(jointCount);  // C_j
    std::vector<Quatf> above(jointCount);  // C of the parent
    for (size_t j = 0; j < jointCount; ++j) {
        const int32_t parent = shaped.joints[j].parent;
        above[j] = parent < 0 ? Quatf(1, 0, 0, 0) : world[size_t(parent)];
        world[j] = above[j] * turned.localRotations[j];
    }
    const auto rewrite = [&](Pose& pose) {
        for (size_t j = 0; j < jointCount; ++j)
            pose.localRotations[j] = glm::normalize(above[j] * pose.localRotations[j] * glm::conjugate(world[j]));
    };
    rewrite(fit.staticPose);
    for (Pose& pose : fit.poses) rewrite(pose);
    for (LandmarkOffset& landmark : fit.landmarks) landmark.offset = glm::dquat(world[landmark.joint]) * landmark.offset;

    MeshData& mesh = shaped.mesh;
    for (size_t v = 0; v < mesh.restPositions.size(); ++v)
        mesh.restPositions[v] = skinVertex(mesh.restPositions[v], mesh.jointIndices[v], mesh.jointWeights[v], moved.data());
    for (size_t j = 0; j < jointCount; ++j) shaped.joints[j].restPosition = transformed(moved[j], shaped.joints[j].restPosition);
}

}  // namespace dpl
