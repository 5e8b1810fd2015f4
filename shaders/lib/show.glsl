// SPDX-License-Identifier: Apache-2.0
// A footprint as the passes that fill pixels read it.
#include "shaders/lib/projected.glsl"

ProjectedSplat dplHiddenSplat() { return dplProjected(uvec4(0u), uvec4(0u)); }

// A footprint of this opacity, black; hidden when no pixel of the target sees 1/255 of it. all: nothing is culled, for measuring. Then what is fainter or turned away
// keeps the box of three standard deviations that plain 3D Gaussian splatting draws, and adds nothing there.
ProjectedSplat dplShow(Footprint f, float opacity, vec2 targetPx, bool all) {
    ProjectedSplat p = dplHiddenSplat();
    if (opacity >= kGpuMinAlpha || all) {
        float level = opacity >= kGpuMinAlpha ? 2.0 * log(opacity / kGpuMinAlpha) : 9.0;
        vec2 radius = sqrt(level * f.variance);
        vec2 low = f.centrePx - radius, high = f.centrePx + radius;
        if (high.x > 0.0 && high.y > 0.0 && low.x < targetPx.x && low.y < targetPx.y) {
            p.place = vec4(f.centrePx, f.conic.x, f.conic.y);
            p.look = uvec4(floatBitsToUint(f.conic.z), dplPackExtent(opacity, radius.x), 0u, floatBitsToUint(f.depthM));
        }
    }
    return p;
}
