// SPDX-License-Identifier: Apache-2.0
// A minimal avatar: two joints, a square of two triangles with a grid of opaque red splats facing +Z, one clip.
#pragma once

#include "sdk/format/avatar_data.h"

namespace dpl::test {

inline AvatarData tinyAvatar(uint32_t splatsPerTriangle = 64) {
    AvatarData a;
    a.name = "tiny";
    a.generator = "doppel tests";
    a.joints = {{"pelvis", -1, {0, 1, 0}, "hips"}, {"left_shoulder", 0, {0, 1.25f, 0}, "leftUpperArm"}};
    a.mesh.restPositions = {{-0.5f, 0.5f, 0}, {0.5f, 0.5f, 0}, {0.5f, 1.5f, 0}, {-0.5f, 1.5f, 0}};
    a.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    a.mesh.colours.assign(4, glm::u8vec4(255, 0, 0, 255));
    a.mesh.jointIndices.assign(4, glm::u16vec4(0));
    a.mesh.jointWeights.assign(4, glm::u8vec4(255, 0, 0, 0));
    a.mesh.layers = {{"body", "body", 0, 4, 0, 2}};
    a.splats.triangleStart = {0, splatsPerTriangle, 2 * splatsPerTriangle};
    const uint32_t side = 8;
    for (uint32_t t = 0; t < 2; ++t)
        for (uint32_t i = 0; i < splatsPerTriangle; ++i) {
            // A grid on the triangle: (u, v) of the unit square, folded into u + v < 1.
            float u = (float(i % side) + 0.5f) / float(side), v = (float(i / side % side) + 0.5f) / float(side);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            a.splats.uv.push_back({u, v});
            a.splats.phi.push_back(0);
            a.splats.scaleM.push_back({0.08f, 0.08f});
            a.splats.opacity.push_back(0.95f);
            a.splats.flags.push_back(kSplatSingleFace);
            for (const float c : {1.0f, 0.0f, 0.0f}) a.splats.sh.push_back((c - 0.5f) / float(0.28209479177387814));
        }
    ClipData turn;
    turn.name = "turn";
    turn.timesS = {0, 1};
    turn.channels = {{0, {Quatf(1, 0, 0, 0), glm::angleAxis(glm::radians(90.0f), Vec3f(0, 1, 0))}}};
    turn.rootTranslations = {{0, 0, 0}, {0, 0.5f, 0}};
    a.clips = {turn};
    return a;
}

}  // namespace dpl::test
