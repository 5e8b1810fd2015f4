// SPDX-License-Identifier: Apache-2.0
// SH colour of every general splat for the views that show it. Its coefficients live in the world: no turn, no brightness.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer SplatBlock { GeneralSplatRecord splats[]; };
layout(std430, binding = 2) readonly buffer ShBlock { float sh[]; };
layout(std430, binding = 3) buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(push_constant) uniform PushBlock { ColourPush push; };

vec3 dplSh(uint base, uint k) { return vec3(sh[base + 3u * k], sh[base + 3u * k + 1u], sh[base + 3u * k + 2u]); }
#include "tools/bench/baseline/shaders/lib/sh.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.splatCount) return;
    for (uint v = 0u; v < push.viewCount; ++v) {
        uint slot = index * push.viewCount + v;
        if (projected[slot].opacity == 0.0) continue;
        vec3 direction = normalize(splats[index].centre.xyz - frame.views[v].eyeWorld.xyz);
        projected[slot].colour.rgb = dplShColour(direction, push.shDegree, index * push.shStride, 1.0);
    }
}
