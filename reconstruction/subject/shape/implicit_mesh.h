// SPDX-License-Identifier: Apache-2.0
// Turns an implicit solid into a clean triangle mesh: marching tetrahedra, then edge collapses, flips and smoothing on the surface.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/math/types.h"

namespace dpl {

struct SurfaceMesh {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
};

using ScalarField = std::function<float(const Vec3f&)>;  // metres, negative inside, gradient length about 1; called from several threads

/** Sample positions of a box-shaped grid, ascending, metres. Spacing may vary, for example be finer at hands and face. */
struct SampleGrid {
    std::vector<float> xs, ys, zs;
};

/** Appends evenly spaced samples over [from, to], at most `step` metres apart. `from` is left out when `samples` is not empty. */
void appendSamples(std::vector<float>& samples, float from, float to, float step);

/** The zero surface inside the grid as a 2-manifold, open only where it leaves the grid. Triangles are counter-clockwise from outside.
 *  Features thinner than a cell may be missed. Same bytes for any thread count. */
SurfaceMesh marchField(const ScalarField& field, const SampleGrid& grid, Jobs& jobs);

struct RemeshOptions {
    std::function<float(const Vec3f&)> edgeLength;  // wanted edge length at a position, metres
    int relaxations = 8;                            // rounds of flips, smoothing and projection onto the surface
};

/** Coarsens `mesh` to the wanted edge length and makes its triangles well shaped. The result is a 2-manifold with the same borders and
 *  with its other vertices on the zero surface of `field`. */
SurfaceMesh remesh(const SurfaceMesh& mesh, const ScalarField& field, const RemeshOptions& options, Jobs& jobs);

/** Keeps the largest connected piece. */
SurfaceMesh largestPiece(const SurfaceMesh& mesh);

/** Drops vertices that no triangle uses and keeps the order of the rest. `oldIndex`, unless null, receives each kept vertex's old index. */
SurfaceMesh withoutUnused(const SurfaceMesh& mesh, std::vector<uint32_t>* oldIndex = nullptr);

/** Area-weighted unit normals. */
std::vector<Vec3f> vertexNormals(std::span<const Vec3f> positions, std::span<const Triangle> triangles);

/** Neighbours of each vertex, ascending. */
std::vector<std::vector<uint32_t>> vertexNeighbours(size_t vertexCount, const std::vector<Triangle>& triangles);

}  // namespace dpl
