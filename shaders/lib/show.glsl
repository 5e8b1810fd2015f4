// SPDX-License-Identifier: Apache-2.0
// Turns a footprint into a ProjectedSplat. Include lib/footprint.glsl first.
#include "shaders/lib/projected.glsl"

ProjectedSplat dplHiddenSplat() { return dplProjected(uvec4(0u), uvec4(0u)); }

/** A black record of this opacity, hidden when α is below 1/255 in every pixel of the target. all: culls nothing, for measurements.
 *  A splat that is too faint or turned away then covers the box of three standard deviations that plain 3D Gaussian splatting draws,
 *  and adds nothing there. */
ProjectedSplat dplShow(Footprint f, float opacity, vec2 targetPx, bool all) {
    ProjectedSplat p = dplHiddenSplat();
    if (opacity >= kMinAlpha || all) {
        float level = opacity >= kMinAlpha ? visibleRadius2(opacity) : 9.0;
        vec2 radius = sqrt(level * vec2(f.varianceX, f.varianceY));
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
