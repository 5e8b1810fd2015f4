// SPDX-License-Identifier: Apache-2.0
// Draco at arm's length: order-preserving encoding of one layer, bounded decoding of anybody's mesh. Internal.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/math/types.h"

namespace dpl {

/** One layer with its own vertex numbers. Positions lie on the lattice of kPositionStepM. */
struct LayerMesh {
    std::vector<Vec3f> positions;
    std::vector<glm::u16vec4> colours;  // linear light, as COLOR_0 wants it
    std::vector<glm::u16vec4> joints;
    std::vector<glm::u8vec4> weights;
    std::vector<glm::uvec3> triangles;
    bool wideJoints = false;  // joints as u16 in the file, else u8
};

constexpr uint32_t kDracoPosition = 0, kDracoColour = 1, kDracoJoints = 2, kDracoWeights = 3;  // unique ids as we write them

/** Sequential encoding: vertices, triangles and corners keep their order; integers are exact, lattice positions too. */
Result<std::vector<uint8_t>> encodeDraco(const LayerMesh& mesh);

struct DracoDecoded {
    std::vector<glm::uvec3> triangles;
    std::map<uint32_t, std::vector<float>> values;  // by unique id: vertexCount × components raw values
    std::map<uint32_t, uint32_t> components;
};

/** Decodes after checking the counts in Draco's own header against what the accessors promise, and against the bytes: at most 8
 *  vertices and 16 triangles a byte. Attributes are checked (≤ 16, ≤ 4 components, ≤ 4 bytes) before their values are allocated. */
Result<DracoDecoded> decodeDraco(std::span<const uint8_t> bytes, uint32_t vertexCount, uint32_t triangleCount);

}  // namespace dpl
