// SPDX-License-Identifier: Apache-2.0
// From shapes on vertices to expressions on control nodes, as an avatar holds them (docs/reference/expressions.md).
//
//   vertices that a shape moves ─► nodes at some of them, farthest first ─► nearest four a vertex, along the surface
//   ─► more nodes where a vertex is off its shape, until none is
//   offsets at the nodes' vertices ─► entries
#pragma once

#include <span>
#include <vector>

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

constexpr float kExpressionNodeSpacingM = 0.006f;  // from a vertex to the nearest node, at most
constexpr float kExpressionOffM = 2e-4f;           // from a vertex to where its shape wants it, at weight 1, at most
constexpr float kLeastExpressionM = 1e-4f;         // smaller offsets are left out

struct ExpressionNodesReport {
    uint32_t nodes = 0, entries = 0;
    float shapesOffM = 0;       // largest distance of a vertex from where its shape wants it, at weight 1
    float correctivesOffM = 0;  // largest change of a vertex' offset by a pose corrective, at coefficients of `reach`
};

/** Gives the avatar these expressions, in rising order; it must have none. Vertices that they move are bound to nodes of their own; there,
 *  its pose correctives are resampled. Other vertices keep their nodes. InvalidArgument: shapes that do not fit the mesh, or more nodes
 * than a file can hold. Deterministic. */
Result<ExpressionNodesReport> addExpressions(AvatarData& avatar, std::span<const ExpressionShape> shapes);

}  // namespace dpl
