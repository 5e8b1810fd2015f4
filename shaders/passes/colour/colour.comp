// SH colour of every splat for the views that show it. The direction and the brightness come from projection.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std430, binding = 0) readonly buffer CodeBlock { uint codes[]; };
layout(std430, binding = 1) readonly buffer ShBlock { uint sh[]; };  // entries of i8, four a word
layout(std430, binding = 2) buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 3) readonly buffer VisibilityBlock { uint visibility[]; };
layout(push_constant) uniform PushBlock { CodesPush push; };
#include "shaders/lib/codes.glsl"

vec3 dplFirst;   // coefficient 0 of this lane's splat, and the steps of bands 1 to 3
vec3 dplSteps;

float dplCode(uint entry, uint at) { return float(int(sh[entry + (at >> 2u)] << (24u - 8u * (at & 3u))) >> 24); }
vec3 dplSh(uint entry, uint k) {
    if (k == 0u) return dplFirst;
    uint at = 3u * (k - 1u);
    return (k < 4u ? dplSteps.x : k < 9u ? dplSteps.y : dplSteps.z) * vec3(dplCode(entry, at), dplCode(entry, at + 1u), dplCode(entry, at + 2u));
}
#include "shaders/lib/sh.glsl"

void main() {
    SplatPlace p = dplPlaceOf(visibility[push.groupCount + gl_WorkGroupID.x], gl_LocalInvocationIndex);
    if (!p.exists) return;
    bool read = false;
    uint entry = 0u;
    for (uint v = 0u; v < push.viewCount; ++v) {
        uint slot = p.splat * push.viewCount + v;
        if (projected[slot].opacity == 0.0) continue;
        if (!read) {
            uint colour = codes[push.firstColour + p.splat];
            vec3 low = vec3(dplChunkFloat(p, kChunkDcMin), dplChunkFloat(p, kChunkDcMin + 1u), dplChunkFloat(p, kChunkDcMin + 2u));
            vec3 high = vec3(dplChunkFloat(p, kChunkDcMax), dplChunkFloat(p, kChunkDcMax + 1u), dplChunkFloat(p, kChunkDcMax + 2u));
            dplFirst = low + (high - low) * vec3(float(colour & 1023u) * (1.0 / 1023.0), float((colour >> 10u) & 2047u) * (1.0 / 2047.0), float(colour >> 21u) * (1.0 / 2047.0));
            dplSteps = vec3(dplChunkFloat(p, kChunkShRange), dplChunkFloat(p, kChunkShRange + 1u), dplChunkFloat(p, kChunkShRange + 2u)) * (1.0 / 127.0);
            entry = p.splat;
            if (push.firstShIndex != 0u) entry = (codes[push.firstShIndex + (p.splat >> 1u)] >> ((p.splat & 1u) * 16u)) & 0xFFFFu;
            entry *= push.shWords;
            read = true;
        }
        vec3 direction = projected[slot].colour.rgb;
        float light = length(direction);
        projected[slot].colour.rgb = dplShColour(direction / light, push.shDegree, entry, light);
    }
}
