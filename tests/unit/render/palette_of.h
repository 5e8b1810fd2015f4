// SPDX-License-Identifier: Apache-2.0
// The palette that the renderer writes before each frame, for tests of single passes.
#pragma once

#include "sdk/avatar/cloth_limits.h"
#include "sdk/avatar/pose_correctives.h"
#include "sdk/render/avatar_upload.h"

namespace dpl {

/** The joints follow jointPose, the control nodes nodePose. */
inline std::vector<gpu::vec4> paletteOf(const AvatarData& avatar, const Pose& jointPose, const Pose& nodePose) {
    std::vector<Mat3x4f> joints;
    jointTransforms(avatar.joints, jointPose, joints);
    std::vector<float> coefficients;
    std::vector<Vec4f> nodes;
    if (!avatar.correctives.empty()) {
        std::vector<Mat3x4f> nodeJoints;
        ClothScratch scratch;
        jointTransforms(avatar.joints, nodePose, nodeJoints);
        const float drawn = correctiveCoefficients(avatar.correctives, nodePose, coefficients).drawn;
        correctiveNodes(avatar.correctives, coefficients, nodes);
        addExpression(avatar.expressions, nodePose.expression, coefficients, nodes);
        ClothLimits(avatar.joints, avatar.mesh, avatar.correctives).apply(nodeJoints, drawn, nodes, scratch);
    }
    std::vector<gpu::vec4> palette(paletteSize(avatar));
    packPalette(joints, nodes, avatar.light, palette);
    return palette;
}

}  // namespace dpl
