// SPDX-License-Identifier: Apache-2.0
// SH colour of each general splat in the views that show it. The coefficients are in the space of the splats, so there is no
// rotation and no brightness.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/projected.glsl"
#include "shaders/lib/views.glsl"
#include "shaders/lib/sh_degree.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
DPL_FOURS(1, SplatBlock, splats);  // lib/general_splat.glsl
DPL_FOURS(2, ShBlock, sh);  // eight halves, coefficient-major, red green blue; padded to whole uvec4
layout(std430, binding = 3) buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(push_constant) uniform PushBlock { ColourPush push; };
#include "shaders/lib/general_splat.glsl"

float dplShHalf(uint base, uint at) {
    uvec4 eight = DPL_FOUR(sh, base + (at >> 3u));
    uint word = (at & 4u) == 0u ? ((at & 2u) == 0u ? eight.x : eight.y) : ((at & 2u) == 0u ? eight.z : eight.w);
    vec2 pair = unpackHalf2x16(word);
    return (at & 1u) == 0u ? pair.x : pair.y;
}
vec3 dplSh(uint base, uint k) { return vec3(dplShHalf(base, 3u * k), dplShHalf(base, 3u * k + 1u), dplShHalf(base, 3u * k + 2u)); }
#include "shaders/lib/sh.glsl"

const uint kShStride = (3u * (kShDegree + 1u) * (kShDegree + 1u) + 7u) / 8u;  // uvec4s of one splat

void shadeIn(ViewData view, uint index, uint slot) {
    if (!dplShown(projected[slot].opacityAndRadius)) return;
    vec3 direction = normalize(dplCentreOf(dplGeneralSplat(index)) - dplEyeWorld(view));
    projected[slot].colour = dplPackColour(dplShColour(direction, index * kShStride, 1.0));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.splatCount) return;
    for (uint v = 0u; v < kViews; ++v) shadeIn(frame.views[v], index, v * frame.splatCount + push.firstSplat + index);
}
