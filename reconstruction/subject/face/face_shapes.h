// SPDX-License-Identifier: Apache-2.0
// Shapes of the expressions as smooth fields about landmarks of a face at rest: for bodies that bring no shapes of their own. Table and
// formulas: docs/reference/expressions.md. Eyelids and lips are skin without a gap here: a blink draws the upper lid over a painted eye,
// and an open jaw stretches the line between the lips.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "reconstruction/subject/body/body_model.h"

namespace dpl {

/** Places on the skin of a face at rest, metres, world: +Y up, facing +Z. */
struct FaceLandmarks {
    Vec3f leftEye{0}, rightEye{0};  // middle of the opening; the subject's left
    Vec3f mouth{0};                 // middle of the line between the lips
    Vec3f chin{0};                  // its lowest point
};

/** Of the built-in body, before morphs. */
FaceLandmarks builtinFace();

/** Whether there is a field for an expression of kExpressionNames: for all but tongueOut, as there is no tongue. */
bool hasFaceShape(size_t expression);

/** Offset of a point of the skin at weight 1, metres; 0 far from what the expression moves. Exactly mirrored left and right. */
Vec3f faceOffset(const FaceLandmarks& face, size_t expression, const Vec3f& point);

/** All expressions that have a field, on these points of the skin. */
std::vector<ExpressionShape> faceShapes(const FaceLandmarks& face, std::span<const Vec3f> points);

}  // namespace dpl
