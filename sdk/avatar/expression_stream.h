// SPDX-License-Identifier: Apache-2.0
// Weights of expressions as other programs send them, by their lists of names. Table: docs/reference/expressions.md, "Streams".
#pragma once

#include <span>

#include "sdk/avatar/rig.h"

namespace dpl {

/** Weights by names: ARKit's, also as Live Link writes them; MediaPipe's `_neutral`, which says nothing; Live Link's nine angles of head
 * and eyes, which are left out; VRM's expressions, of versions 1 and 0, each a mixture of ARKit's; and those of OpenXR's
 * XR_FB_face_tracking2 (xr_expressions.h). What several names move is added up. All weights are held in 0 to 1. No names: weights.size()
 * must be 52 in ARKit's order, 61 in Live Link's, or 63 or 70 in OpenXR's. InvalidArgument: another count without names, an unknown name,
 * or a weight that is not a number; the text names it. */
Result<ExpressionWeights> expressionFrom(std::span<const char* const> names, std::span<const float> weights);

}  // namespace dpl
