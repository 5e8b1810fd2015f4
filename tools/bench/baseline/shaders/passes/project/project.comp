// SPDX-License-Identifier: Apache-2.0
// Footprint, opacity and visibility of every splat in every view; the sort depth of those that some view shows.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
#include "tools/bench/baseline/shaders/lib/footprint.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer SplatBlock { SplatRecord splats[]; };
layout(std430, binding = 2) readonly buffer TriangleBlock { TriangleFrame triangles[]; };
layout(std430, binding = 3) writeonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 4) writeonly buffer DepthBlock { uint sortDepth[]; };  // float bits, kInvisibleKey = in no view
layout(push_constant) uniform PushBlock { SplatPush push; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.splatCount) return;
    SplatRecord s = splats[index];
    uint parent = s.triangleAndFlags & kTriangleMask;
    vec4 v0 = triangles[parent].v0, v1 = triangles[parent].v1, v2 = triangles[parent].v2;
    vec4 f0 = triangles[parent].f0, f1 = triangles[parent].f1;
    vec3 normal = vec3(v1.w, v2.w, f0.w);
    vec3 centre = (1.0 - s.uv.x - s.uv.y) * v0.xyz + s.uv.x * v1.xyz + s.uv.y * v2.xyz;
    vec3 axis1 = s.s1Cos * f0.xyz + s.s1Sin * f1.xyz, axis2 = s.s2Cos * f1.xyz - s.s2Sin * f0.xyz;
    bool gated = ((s.triangleAndFlags >> kFlagShift) & kGateFlag) != 0u;
    bool seen = false;
    for (uint v = 0u; v < push.viewCount; ++v) {
        ViewData view = frame.views[v];
        ProjectedSplat p;
        p.opacity = 0.0;
        p.centrePx = p.radiusPx = vec2(0.0);
        p.conicA = p.conicB = p.conicC = 0.0;
        p.colour = vec4(0.0);
        if (v0.w != 0.0) {
            Footprint f = dplProject(view, dplToView(view, centre), dplRotateToView(view, axis1), dplRotateToView(view, axis2), frame.target.z);
            if (f.visible) {
                float opacity = s.opacity * dplNearFade(f.depthM);
                if (frame.counts.w != 0u) opacity *= f.compensation;
                if (gated) opacity *= dplSingleFaceGate(normal, centre, view.eyeWorld.xyz);
                if (opacity >= kGpuMinAlpha) {
                    float level = 2.0 * log(opacity / kGpuMinAlpha);
                    vec2 radius = sqrt(level * f.variance);
                    vec2 low = f.centrePx - radius, high = f.centrePx + radius;
                    if (high.x > 0.0 && high.y > 0.0 && low.x < frame.target.x && low.y < frame.target.y) {
                        p.centrePx = f.centrePx;
                        p.radiusPx = radius;
                        p.conicA = f.conic.x;
                        p.conicB = f.conic.y;
                        p.conicC = f.conic.z;
                        p.opacity = opacity;
                        p.colour.w = f.depthM;
                        seen = true;
                    }
                }
            }
        }
        projected[index * push.viewCount + v] = p;
    }
    sortDepth[index] = seen ? floatBitsToUint(dot(frame.sortAxis.xyz, centre)) : kInvisibleKey;
}
