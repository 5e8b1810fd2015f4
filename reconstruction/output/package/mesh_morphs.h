// SPDX-License-Identifier: Apache-2.0
// The expressions of an avatar as morph targets of its exported mesh (docs/reference/expressions.md, "In other files").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"
#include "sdk/format/gltf_mesh.h"

namespace dpl {

/** The vertices of an avatar with one of its expressions at weight 1. */
struct ExpressedMesh {
    uint8_t expression = 0;  // of kExpressionNames
    std::vector<Vec3f> positions;
};

/** The vertices of an avatar at rest as it is drawn: with the correctives of that pose. */
struct DrawnAtRest {
    std::vector<Vec3f> positions;
    std::vector<ExpressedMesh> expressed;  // with each expression that the avatar has, in rising order
};
DrawnAtRest drawnAtRest(const AvatarData& avatar);

/** The morphs of a mesh whose vertices are copies of others: `old` tells of which. rest and expressed have the vertices before. Offsets are
 *  multiples of kPositionStepM and changes of normals of kTurnStep, so smaller ones are 0. An expression that moves nothing is left out. */
constexpr float kTurnStep = 1.0f / 4096;
std::vector<MeshMorph> morphsOf(std::span<const Vec3f> rest, std::span<const ExpressedMesh> expressed, std::span<const Triangle> triangles,
                                std::span<const uint32_t> old);

}  // namespace dpl
