// SPDX-License-Identifier: Apache-2.0
// What the renderer writes into a palette before each frame, for tests of single passes.
#pragma once

#include "sdk/avatar/pose_correctives.h"
#include "sdk/render/avatar_upload.h"

namespace dpl {

/** Joints may stand in another pose than the one that the control nodes follow. */
inline std::vector<gpu::vec4> paletteOf(const AvatarData& avatar, const Pose& jointPose, const Pose& nodePose) {
    std::vector<Mat3x4f> joints;
    jointTransforms(avatar.joints, jointPose, joints);
    std::vector<float> coefficients;
    std::vector<Vec4f> nodes;
    if (!avatar.correctives.empty())
        correctiveCoefficients(avatar.correctives, nodePose, coefficients), correctiveNodes(avatar.correctives, coefficients, nodes);
    std::vector<gpu::vec4> palette(paletteSize(avatar));
    packPalette(joints, nodes, palette);
    return palette;
}

}  // namespace dpl
