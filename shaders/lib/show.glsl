// SPDX-License-Identifier: Apache-2.0
// Turns a footprint into a ProjectedSplat. Include lib/footprint.glsl first.
#include "shaders/lib/projected.glsl"

ProjectedSplat dplHiddenSplat() { return dplProjected(uvec4(0u), uvec4(0u)); }

/** A black record of this opacity, hidden when α is below 1/255 in every pixel of the target. */
ProjectedSplat dplShow(Footprint f, float opacity, vec2 targetPx) {
    ProjectedSplat p = dplHiddenSplat();
    if (opacity >= kMinAlpha) {
        vec2 radius = sqrt(visibleRadius2(opacity) * vec2(f.varianceX, f.varianceY));
        vec2 low = f.centrePx - radius, high = f.centrePx + radius;
        if (high.x > 0.0 && high.y > 0.0 && low.x < targetPx.x && low.y < targetPx.y) {
            p.centrePx = f.centrePx;
            p.conicA = f.conicA;
            p.conicB = f.conicB;
            p.conicC = f.conicC;
            p.opacityAndRadius = dplPackOpacityAndRadius(opacity, radius.x);
            p.depthM = f.depthM;
        }
    }
    return p;
}
