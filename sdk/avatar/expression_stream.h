// SPDX-License-Identifier: Apache-2.0
// Weights of expressions as other programs send them, by their lists of names. Table: docs/reference/expressions.md, "Streams".
#pragma once

#include <span>

#include "sdk/avatar/rig.h"

namespace dpl {

/** Weights by names: ARKit's, also as Live Link writes them; MediaPipe's `_neutral`, which says nothing; Live Link's nine angles of head
 * and eyes, which are left out; and VRM's expressions, each a mixture of ARKit's. What several names move is added up. All weights are held
 * in 0 to 1. No names: weights.size() must be 52 in ARKit's order, or 61 in Live Link's. InvalidArgument: another count without names, an
 * unknown name, or a weight that is not a number; the text names it. */
Result<ExpressionWeights> expressionFrom(std::span<const char* const> names, std::span<const float> weights);

}  // namespace dpl
