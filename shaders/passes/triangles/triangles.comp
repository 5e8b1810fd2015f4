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
#include "shaders/lib/quaternion.glsl"
#include "shaders/lib/views.glsl"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
DPL_FOURS(1, TriangleBlock, triangles);  // TriangleRecord
DPL_FOURS(2, PosedBlock, posed);  // PosedVertex
layout(std430, binding = 3) writeonly buffer TriangleFrameBlock { TriangleFrame frames[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { TrianglePush push; };

shared uint groupTriangles[2];  // in view, facing
shared uint groupSplats[2];

/** Bits of TriangleFrame.shows for view 0. */
uint shownIn(ViewData view, vec3 v0, vec3 v1, vec3 v2, vec3 normal, float reach, float rootLevel) {
    if (!dplTriangleInView(view, v0, v1, v2, reach, rootLevel, frame.targetPx, frame.kappaPx2)) return 0u;
    return dot(normal, dplEyeWorld(view) - v0) > 0.0 ? kShowsFree | kShowsGated : kShowsFree;
}

PosedVertex vertexAt(uint vertex) {
    vec4 v = dplFloats(DPL_FOUR(posed, vertex));
    return PosedVertex(v.x, v.y, v.z, v.w);
}

/** corners: the fourth uvec4 of the record. */
uint componentOf(uvec4 corners) { return corners.w; }

TriangleRecord triangleAt(uint triangle, uvec4 corners) {
    uint at = kTriangleFours * triangle;
    vec4 t1 = dplFloats(DPL_FOUR(triangles, at)), t2 = dplFloats(DPL_FOUR(triangles, at + 1u)), normal = dplFloats(DPL_FOUR(triangles, at + 2u));
    uvec4 splats = DPL_FOUR(triangles, at + 4u);
    return TriangleRecord(t1.x, t1.y, t1.z, t1.w, t2.x, t2.y, t2.z, t2.w, normal.x, normal.y, normal.z, normal.w, corners.x, corners.y, corners.z,
                          componentOf(corners), uintBitsToFloat(splats.x), uintBitsToFloat(splats.y), splats.z, splats.w);
}

void main() {
    uint lane = gl_LocalInvocationIndex, index = gl_WorkGroupID.x * kVertexGroup + lane;
    if (lane < 2u) groupTriangles[lane] = groupSplats[lane] = 0u;
    barrier();
    if (index < push.triangleCount) {
        TriangleFrame f = TriangleFrame(0.0, 0.0, 0.0, 0u, 0.0, 0.0, 0.0, 0u, 0.0, 0.0, 0.0, 0u, 0.0, 0.0, 0.0, 0u, 0.0, 0.0, 0.0, 0u);
        uvec4 corners = DPL_FOUR(triangles, kTriangleFours * index + 3u);
        uint component = componentOf(corners);
        if (component != 0u && (frame.unseenComponents >> (component - 1u) & 1u) == 0u) {
            TriangleRecord rest = triangleAt(index, corners);
            PosedVertex corner0 = vertexAt(rest.corner0), corner1 = vertexAt(rest.corner1), corner2 = vertexAt(rest.corner2);
            vec3 v0 = vec3(corner0.x, corner0.y, corner0.z), v1 = vec3(corner1.x, corner1.y, corner1.z), v2 = vec3(corner2.x, corner2.y, corner2.z);
            PosedTriangle now = posedTriangle(rest.inverse00, rest.inverse01, rest.inverse11, v0, v1, v2);
            BoundedPlane plane = boundedPlane(now.f0, now.f1, now.turned1, now.turned2);
            if (now.valid && plane.shown > 0.0) {
                mat3 restFrame = mat3(vec3(rest.restT1X, rest.restT1Y, rest.restT1Z), vec3(rest.restT2X, rest.restT2Y, rest.restT2Z),
                                      vec3(rest.restNormalX, rest.restNormalY, rest.restNormalZ));
                mat3 worldFromRest = mat3(now.turned1, now.turned2, now.normal) * transpose(restFrame);
                vec4 turn = dplQuaternionOf(worldFromRest);
                // the last factor absorbs float rounding
                float reach = rest.reach * frame.largestGrowth * largestStretch(plane.f0, plane.f1) * 1.0001;
                uint shown = 0u;
                for (uint v = 0u; v < kViews; ++v) shown |= shownIn(frame.views[v], v0, v1, v2, now.normal, reach, rest.rootLevel) << v;
                f = TriangleFrame(v0.x, v0.y, v0.z, shown, v1.x, v1.y, v1.z, packSnorm2x16(turn.xy), v2.x, v2.y, v2.z, packSnorm2x16(turn.zw),
                                  plane.f0.x, plane.f0.y, plane.f0.z, packHalf2x16(vec2(corner0.light, corner1.light)),
                                  plane.f1.x, plane.f1.y, plane.f1.z, packHalf2x16(vec2(corner2.light, 1.0 - plane.shown)));
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
