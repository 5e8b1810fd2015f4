// SH colour of every splat for the views that show it. The direction and the brightness come from projection.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std430, binding = 0) readonly buffer ShBlock { float sh[]; };
layout(std430, binding = 1) buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 2) readonly buffer VisibilityBlock { uint visibility[]; };
layout(push_constant) uniform PushBlock { ColourPush push; };

vec3 dplSh(uint base, uint k) { return vec3(sh[base + 3u * k], sh[base + 3u * k + 1u], sh[base + 3u * k + 2u]); }
#include "shaders/lib/sh.glsl"

void main() {
    uint index = visibility[push.chunkCount + gl_WorkGroupID.x] * kSplatGroup + gl_LocalInvocationIndex;
    if (index >= push.splatCount) return;
    for (uint v = 0u; v < push.viewCount; ++v) {
        uint slot = index * push.viewCount + v;
        if (projected[slot].opacity == 0.0) continue;
        vec3 direction = projected[slot].colour.rgb;
        float light = length(direction);
        projected[slot].colour.rgb = dplShColour(direction / light, push.shDegree, index * push.shStride, light);
    }
}
