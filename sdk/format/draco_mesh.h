// SPDX-License-Identifier: Apache-2.0
// All use of Draco: encodes a layer and keeps its order; decodes foreign meshes within limits. Internal.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/math/types.h"

namespace dpl {

/** One layer; triangles index its own vertices. Positions are multiples of kPositionStepM. */
struct LayerMesh {
    std::vector<Vec3f> positions;
    std::vector<glm::u16vec4> colours;  // linear light, as glTF's COLOR_0; empty: none
    std::vector<Vec3f> normals;         // unit; empty: none
    std::vector<Vec2f> uv;              // texture coordinates, 0 to 1; empty: none
    std::vector<glm::u16vec4> joints;
    std::vector<glm::u8vec4> weights;
    std::vector<glm::uvec3> triangles;
    bool wideJoints = false;  // joints as u16 in the file, else u8
};

constexpr uint32_t kDracoPosition = 0, kDracoColour = 1, kDracoJoints = 2, kDracoWeights = 3, kDracoNormal = 4,
                   kDracoUv = 5;  // unique ids in files by Doppel

/** Encodes sequentially: vertices, triangles and corners keep their order. Integers and lattice positions are exact;
 *  normals are within 0.1°, texture coordinates within 2⁻¹⁷. */
Result<std::vector<uint8_t>> encodeDraco(const LayerMesh& mesh);

struct DracoDecoded {
    std::vector<glm::uvec3> triangles;
    std::map<uint32_t, std::vector<float>> values;  // by unique id: vertexCount × components values, not normalised
    std::map<uint32_t, uint32_t> components;
};

/** Decodes a mesh. First checks the counts in Draco's header against those of the accessors and against the size: at most 8 vertices and
 *  16 triangles per byte. Checks the attributes (≤ 16, ≤ 4 components, ≤ 4 bytes each) before their values are allocated. */
Result<DracoDecoded> decodeDraco(std::span<const uint8_t> bytes, uint32_t vertexCount, uint32_t triangleCount);

}  // namespace dpl
