// SPDX-License-Identifier: Apache-2.0
// Writes one posed frame for each triangle: corners, the columns of F, the polar rotation and the brightness
// (docs/reference/binding.md). It also finds which views may show its splats: those whose frustum it touches (lib/cull.glsl), and for
// single-face splats only those on its front side, where their gate is above 0. Triangles of components that no view sees are marked as
// hidden without reading their vertices.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/footprint.glsl"
#include "sdk/math/formulas/pose.inl"
#include "shaders/lib/cull.glsl"
#include "shaders/lib/views.glsl"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
DPL_FOURS(1, TriangleBlock, triangles);  // TriangleRecord
DPL_FOURS(2, PosedBlock, posed);
layout(std430, binding = 3) writeonly buffer TriangleFrameBlock { TriangleFrame frames[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { TrianglePush push; };

shared uint groupTriangles[2];  // in view, facing
shared uint groupSplats[2];

/** Bits of TriangleFrame.corner0.w for view 0. */
uint shownIn(ViewData view, vec3 v0, vec3 v1, vec3 v2, vec3 normal, float reach, float rootLevel) {
    if (frame.cullNothing != 0u) return kShowsFree | kShowsGated;
    if (!dplTriangleInView(view, v0, v1, v2, reach, rootLevel, frame.targetPx, frame.kappaPx2)) return 0u;
    return dot(normal, view.eyeWorld.xyz - v0) > 0.0 ? kShowsFree | kShowsGated : kShowsFree;
}

uvec4 bitsOf(vec3 v, uint w) { return uvec4(floatBitsToUint(v.x), floatBitsToUint(v.y), floatBitsToUint(v.z), w); }

/** Unit quaternion (x, y, z, w) of a rotation. */
vec4 quaternionOf(mat3 m) {
    vec4 q;
    if (m[0][0] + m[1][1] + m[2][2] > 0.0) q = vec4(m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0], 1.0 + m[0][0] + m[1][1] + m[2][2]);
    else if (m[0][0] > m[1][1] && m[0][0] > m[2][2]) q = vec4(1.0 + m[0][0] - m[1][1] - m[2][2], m[0][1] + m[1][0], m[2][0] + m[0][2], m[1][2] - m[2][1]);
    else if (m[1][1] > m[2][2]) q = vec4(m[0][1] + m[1][0], 1.0 + m[1][1] - m[0][0] - m[2][2], m[1][2] + m[2][1], m[2][0] - m[0][2]);
    else q = vec4(m[2][0] + m[0][2], m[1][2] + m[2][1], 1.0 + m[2][2] - m[0][0] - m[1][1], m[0][1] - m[1][0]);
    return q * inversesqrt(dot(q, q));
}

void main() {
    uint lane = gl_LocalInvocationIndex, index = gl_WorkGroupID.x * kVertexGroup + lane;
    if (lane < 2u) groupTriangles[lane] = groupSplats[lane] = 0u;
    barrier();
    if (index < push.triangleCount) {
        TriangleFrame f;
        f.corner0 = f.corner1 = f.corner2 = f.column0 = f.column1 = uvec4(0u);
        TriangleRecord rest;
        rest.corners = DPL_FOUR(triangles, 5u * index + 3u);
        if (rest.corners.w != 0u && (frame.unseenComponents >> (rest.corners.w - 1u) & 1u) == 0u) {
            rest.restT1 = dplFloats(DPL_FOUR(triangles, 5u * index));
            rest.restT2 = dplFloats(DPL_FOUR(triangles, 5u * index + 1u));
            rest.restNormal = dplFloats(DPL_FOUR(triangles, 5u * index + 2u));
            uvec4 last = DPL_FOUR(triangles, 5u * index + 4u);
            rest.reach = uintBitsToFloat(last.x);
            rest.rootLevel = uintBitsToFloat(last.y);
            rest.freeSplats = last.z;
            rest.gatedSplats = last.w;
            vec4 corner0 = dplFloats(DPL_FOUR(posed, rest.corners.x)), corner1 = dplFloats(DPL_FOUR(posed, rest.corners.y)), corner2 = dplFloats(DPL_FOUR(posed, rest.corners.z));  // w: brightness
            vec3 v0 = corner0.xyz, v1 = corner1.xyz, v2 = corner2.xyz;
            PosedTriangle now = posedTriangle(rest.restT1.w, rest.restT2.w, rest.restNormal.w, v0, v1, v2);
            if (now.valid) {
                mat3 worldFromRest = mat3(now.turned1, now.turned2, now.normal) *
                                     transpose(mat3(rest.restT1.xyz, rest.restT2.xyz, rest.restNormal.xyz));
                vec4 turn = quaternionOf(worldFromRest);
                // the last factor absorbs float rounding
                float reach = rest.reach * frame.largestGrowth * largestStretch(now.f0, now.f1) * 1.0001;
                uint shown = 0u;
                for (uint v = 0u; v < kViews; ++v) shown |= shownIn(frame.views[v], v0, v1, v2, now.normal, reach, rest.rootLevel) << v;
                f.corner0 = bitsOf(v0, shown);
                f.corner1 = bitsOf(v1, packSnorm2x16(turn.xy));
                f.corner2 = bitsOf(v2, packSnorm2x16(turn.zw));
                f.column0 = bitsOf(now.f0, packHalf2x16(vec2(corner0.w, corner1.w)));
                f.column1 = bitsOf(now.f1, packHalf2x16(vec2(corner2.w, 0.0)));
                uint facing = (shown != 0u ? rest.freeSplats : 0u) + (shown >= kShowsGated ? rest.gatedSplats : 0u);
                if (shown != 0u && rest.freeSplats + rest.gatedSplats != 0u) {
                    atomicAdd(groupTriangles[0], 1u);
                    atomicAdd(groupSplats[0], rest.freeSplats + rest.gatedSplats);
                }
                if (facing != 0u) {
                    atomicAdd(groupTriangles[1], 1u);
                    atomicAdd(groupSplats[1], facing);
                }
            }
        }
        frames[index] = f;
    }
    barrier();
    if (lane == 0u && groupTriangles[0] != 0u) {
        atomicAdd(counts.trianglesInView, groupTriangles[0]);
        atomicAdd(counts.trianglesFacing, groupTriangles[1]);
        atomicAdd(counts.splatsInView, groupSplats[0]);
        atomicAdd(counts.splatsFacing, groupSplats[1]);
    }
}
