// SPDX-License-Identifier: Apache-2.0
// From an implicit solid to a clean triangle mesh: marching tetrahedra, then edge collapse, flips and smoothing on the surface.
#pragma once

#include <functional>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/math/types.h"

namespace dpl {

struct SurfaceMesh {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
};

using ScalarField = std::function<float(const Vec3f&)>;  // metres, negative inside, slope about 1; called from several threads

/** Sample positions of a box-shaped grid, rising; spacing may vary so that hands and faces get more samples. */
struct SampleGrid {
    std::vector<float> xs, ys, zs;
};

/** Evenly spaced samples over [from, to], `step` metres or a little less apart. */
void appendSamples(std::vector<float>& samples, float from, float to, float step);

/** The zero surface inside the grid as a closed, outward counter-clockwise 2-manifold (open where it leaves the grid).
 *  Same bytes for any thread count. */
SurfaceMesh marchField(const ScalarField& field, const SampleGrid& grid, Jobs& jobs);

struct RemeshOptions {
    std::function<float(const Vec3f&)> edgeLength;  // wanted edge length, metres
    int relaxations = 8;                            // rounds of flips, smoothing and projection to the field after collapsing
};

/** Coarsens `mesh` to the wanted edge length and makes its triangles well shaped. Stays a 2-manifold; vertices end on the field. */
SurfaceMesh remesh(const SurfaceMesh& mesh, const ScalarField& field, const RemeshOptions& options, Jobs& jobs);

/** Keeps the largest connected piece. */
SurfaceMesh largestPiece(const SurfaceMesh& mesh);

/** Drops vertices that no triangle uses; keeps the order of the rest. `oldIndex`, when given, receives the old number of each. */
SurfaceMesh withoutUnused(const SurfaceMesh& mesh, std::vector<uint32_t>* oldIndex = nullptr);

/** Area-weighted unit normals. */
std::vector<Vec3f> vertexNormals(const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles);

/** Neighbours of each vertex, in rising order. */
std::vector<std::vector<uint32_t>> vertexNeighbours(size_t vertexCount, const std::vector<Triangle>& triangles);

}  // namespace dpl
