// SPDX-License-Identifier: Apache-2.0
// Whether splats of a triangle can show in a view: applies sdk/math/formulas/cull.inl to its corners. Include lib/footprint.glsl first.
#include "sdk/math/formulas/cull.inl"

bool dplTriangleInView(ViewData view, vec3 corner0, vec3 corner1, vec3 corner2, float reachM, float rootLevel, vec2 targetPx, float kappa) {
    Lens lens = dplLens(view);
    CullMargin margin = cullMargin(lens, reachM, rootLevel, kappa, 0.02);  // 0.02 px absorb float rounding
    CullSides sides = cullSides(lens, margin, targetPx, dplToView(view, corner0));
    sides = eitherSides(sides, cullSides(lens, margin, targetPx, dplToView(view, corner1)));
    return mayShow(eitherSides(sides, cullSides(lens, margin, targetPx, dplToView(view, corner2))));
}
