// SPDX-License-Identifier: Apache-2.0
// Cuts a mesh along lines where values at its vertices change sign, so that a border between labels is smooth and not a zigzag of
// triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {

/** A mesh with values at its vertices that cuts interpolate, and a tag at each triangle that its parts inherit. */
struct TaggedMesh {
    SurfaceMesh mesh;
    size_t columns = 0;
    std::vector<float> rows;    // V × columns
    std::vector<uint8_t> tags;  // F
};

/** Splits the triangles with tag `open` along the zero line of `value` (one per vertex), and tags their parts on the positive side
 *  `positive`. Neighbours with other tags are split where they share a cut edge, so that the mesh stays conforming. A cut nearer to a
 * vertex than a fifth of its edge goes through the vertex, so that no sliver arises. */
void cutAtZero(TaggedMesh& tagged, std::vector<float> value, uint8_t open, uint8_t positive);

}  // namespace dpl
