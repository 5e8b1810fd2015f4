// SPDX-License-Identifier: Apache-2.0
// Geometry of a .glb in the codecs of EXT_meshopt_compression, which browsers decode faster than they fetch.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruction/output/package/mesh_atlas.h"
#include "sdk/core/result.h"

namespace dpl {

/** Puts triangles, and the vertices after them, in the order that the codecs write in the fewest bytes; each layer keeps its own. */
void orderForMeshopt(SeamedMesh& mesh);

/** Steps of what is rounded, so that it is written by fewer bits: each number is a multiple, at most half a step from what it was.
 *  Positions of a written mesh are such multiples already. */
constexpr float kMeshoptStep = 1.0f / 65536;  // positions, metres; texture coordinates; rotations
constexpr float kMeshoptNormalStep = 1.0f / 4096;

/** Compresses meshes, morph targets and animations of a plain .glb by writeGltfMesh(). Readers must know EXT_meshopt_compression; a buffer
 *  without bytes, as the extension has it, stands for what they decode. Pictures stay as they are. Deterministic. CorruptData: no such
 *  file. */
Result<std::vector<uint8_t>> compressByMeshopt(std::span<const uint8_t> glb);

}  // namespace dpl
