// SPDX-License-Identifier: Apache-2.0
// SH colour of every splat for the views that show it. The direction is turned into the rest frame of the splat's triangle.
// DPL_LIT: multiplied by the brightness that the pose gives its triangle.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer SplatBlock { SplatRecord splats[]; };
layout(std430, binding = 2) readonly buffer TriangleBlock { TriangleFrame triangles[]; };
layout(std430, binding = 3) readonly buffer ShBlock { float sh[]; };
layout(std430, binding = 4) buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(push_constant) uniform PushBlock { ColourPush push; };

vec3 dplSh(uint base, uint k) { return vec3(sh[base + 3u * k], sh[base + 3u * k + 1u], sh[base + 3u * k + 2u]); }
#include "tools/bench/baseline/shaders/lib/sh.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.splatCount) return;
    for (uint v = 0u; v < push.viewCount; ++v) {
        uint slot = index * push.viewCount + v;
        if (projected[slot].opacity == 0.0) continue;
        SplatRecord s = splats[index];
        uint parent = s.triangleAndFlags & kTriangleMask;
        vec3 centre = (1.0 - s.uv.x - s.uv.y) * triangles[parent].v0.xyz + s.uv.x * triangles[parent].v1.xyz + s.uv.y * triangles[parent].v2.xyz;
        vec3 world = normalize(centre - frame.views[v].eyeWorld.xyz);
        vec3 rest = vec3(dot(triangles[parent].worldFromRest0.xyz, world), dot(triangles[parent].worldFromRest1.xyz, world),
                         dot(triangles[parent].worldFromRest2.xyz, world));
#ifdef DPL_LIT
        vec3 corner = vec3(triangles[parent].worldFromRest0.w, triangles[parent].worldFromRest1.w, triangles[parent].worldFromRest2.w);
        float light = corner.x + s.uv.x * (corner.y - corner.x) + s.uv.y * (corner.z - corner.x);
#else
        const float light = 1.0;
#endif
        projected[slot].colour.rgb = dplShColour(rest, push.shDegree, index * push.shStride, light);
    }
}
