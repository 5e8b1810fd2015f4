// SPDX-License-Identifier: Apache-2.0
// A footprint as the record that the passes which fill pixels read. Include lib/footprint.glsl first.
#include "shaders/lib/projected.glsl"

ProjectedSplat dplHiddenSplat() { return dplProjected(uvec4(0u), uvec4(0u)); }

/** Black, with this opacity; hidden when no pixel of the target sees 1/255 of it. all: nothing is culled, for measurements. Then a splat that
 *  is fainter or turned away keeps the box of three standard deviations that plain 3D Gaussian splatting draws, and adds nothing there. */
ProjectedSplat dplShow(Footprint f, float opacity, vec2 targetPx, bool all) {
    ProjectedSplat p = dplHiddenSplat();
    if (opacity >= kMinAlpha || all) {
        float level = opacity >= kMinAlpha ? visibleRadius2(opacity) : 9.0;
        vec2 radius = sqrt(level * vec2(f.varianceX, f.varianceY));
        vec2 low = f.centrePx - radius, high = f.centrePx + radius;
        if (high.x > 0.0 && high.y > 0.0 && low.x < targetPx.x && low.y < targetPx.y) {
            p.place = vec4(f.centrePx, f.conicA, f.conicB);
            p.look = uvec4(floatBitsToUint(f.conicC), dplPackExtent(opacity, radius.x), 0u, floatBitsToUint(f.depthM));
        }
    }
    return p;
}
