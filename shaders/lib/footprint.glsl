// SPDX-License-Identifier: Apache-2.0
// Footprints in a view of the frame: sdk/math/formulas/footprint.inl applied to ViewData.
#include "shaders/lib/formulas.glsl"
#include "sdk/math/formulas/footprint.inl"

vec3 dplRotateToView(ViewData view, vec3 world) {
    return vec3(dot(view.viewFromWorldRow0.xyz, world), dot(view.viewFromWorldRow1.xyz, world), dot(view.viewFromWorldRow2.xyz, world));
}

vec3 dplToView(ViewData view, vec3 world) {
    return dplRotateToView(view, world) + vec3(view.viewFromWorldRow0.w, view.viewFromWorldRow1.w, view.viewFromWorldRow2.w);
}

Lens dplLens(ViewData view) {
    return Lens(view.focalPx, view.centrePx, vec2(view.minSlopeX, view.minSlopeY), vec2(view.maxSlopeX, view.maxSlopeY));
}

/** Gate of a single-face splat. All arguments are in world space. */
float dplSingleFaceGate(vec3 normal, vec3 centre, vec3 eye) {
    vec3 toEye = eye - centre;
    return singleFaceGate(dot(normal, toEye), length(toEye));
}
