// SPDX-License-Identifier: Apache-2.0
// A parametric body: a rigged mesh with shape morphs and named keypoints. The importers and the built-in subject produce it.
#pragma once

#include <string>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** One shape direction. Value 0 is the mean body; ±1 is about one standard deviation of the population. */
struct ShapeMorph {
    std::string name;  // "height", "weight", "build" ...
    float minValue = -3, maxValue = 3;
    std::vector<Vec3f> vertexOffsets;  // one per vertex, metres at value 1
    std::vector<Vec3f> jointOffsets;   // one per joint, metres at value 1
};

/** A named 3D point on the body: a weighted sum of skinned vertices and posed joints (weights sum to 1). */
struct BodyKeypoint {
    std::string name;  // one of scanKeypointNames() or handKeypointNames(): "nose", "shoulder_l", "index4_l" ...
    std::vector<std::pair<uint32_t, float>> vertices;
    std::vector<std::pair<uint32_t, float>> joints;
};

/** What one of the 52 expressions of kExpressionNames moves, at weight 1. */
struct ExpressionShape {
    uint8_t expression = 0;
    std::vector<Vec3f> offsetsM;  // one per vertex, at rest
};

struct BodyModel {
    std::string name;
    std::vector<JointData> joints;  // 55 for the built-in body; humanoidBone is filled where known
    MeshData mesh;                  // rest pose: A- or T-pose, facing +Z, feet at y = 0; layers[0] is the body
    std::vector<ShapeMorph> morphs;
    std::vector<BodyKeypoint> keypoints;
    std::vector<ExpressionShape> expressions;  // in rising order; empty: its face cannot move
};

}  // namespace dpl
