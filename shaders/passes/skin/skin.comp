// SPDX-License-Identifier: Apache-2.0
// Poses every vertex with its four joints (unorm8 weights) and keeps the extent along the sort axis, which is the range of the depth
// keys. A vertex of components that no view sees is not written, because no pass reads it in this frame.
// DPL_CORRECTED: first moves the rest position by the control nodes of the pose, and writes the vertex's brightness
// (sdk/avatar/pose_correctives.h). Where the light of the scene is known, the posed normal decides on the brightness too
// (sdk/avatar/scene_light.h).
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/order.glsl"
#include "shaders/lib/formulas.glsl"
#include "sdk/math/formulas/sh.inl"
#include "sdk/math/formulas/light.inl"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
// three rows of G_j for each joint; then one vec4 for each control node: offset, and change of the brightness; then, where there is light
// of the scene, its coefficients
DPL_FOURS(1, PaletteBlock, palette);
DPL_FOURS(2, VertexBlock, vertices);  // VertexRecord; DPL_CORRECTED: CorrectedVertexRecord
layout(std430, binding = 3) writeonly buffer PosedBlock { PosedVertex posed[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { VertexPush push; };

shared uint groupMax;
shared uint groupMinInverted;

vec4 paletteRow(uint row) { return dplFloats(DPL_FOUR(palette, row)); }

void addJoint(inout vec3 sum, vec4 rest, uint joint, uint weight) {
    float w = float(weight) * (1.0 / 255.0);
    sum += w * vec3(dot(paletteRow(joint * 3u), rest), dot(paletteRow(joint * 3u + 1u), rest), dot(paletteRow(joint * 3u + 2u), rest));
}

// The compiler drops the reads of members that a caller does not use.
#ifdef DPL_CORRECTED
CorrectedVertexRecord vertexAt(uint vertex) {
    uint at = kCorrectedVertexFours * vertex;
    uvec4 a = DPL_FOUR(vertices, at), b = DPL_FOUR(vertices, at + 1u), c = DPL_FOUR(vertices, at + 2u);
    vec3 rest = uintBitsToFloat(a.xyz);
    return CorrectedVertexRecord(rest.x, rest.y, rest.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, 0u);
}
#else
VertexRecord vertexAt(uint vertex) {
    uvec4 a = DPL_FOUR(vertices, kVertexFours * vertex), b = DPL_FOUR(vertices, kVertexFours * vertex + 1u);
    vec3 rest = uintBitsToFloat(a.xyz);
    return VertexRecord(rest.x, rest.y, rest.z, a.w, b.x, b.y, b.z, b.w);
}
#endif

bool seen(uint vertex) { return frame.unseenComponents == 0u || (vertexAt(vertex).components & ~frame.unseenComponents) != 0u; }

#ifdef DPL_CORRECTED
vec4 nodeShare(uint node, uint weight) { return float(weight) * (1.0 / 255.0) * paletteRow(push.firstNode + node); }
#endif

/** A point (w 1) or a direction (w 0) by its four joints. */
vec3 skinned(vec4 rest, uint joints01, uint joints23, uint weights) {
    vec3 sum = vec3(0.0);
    addJoint(sum, rest, joints01 & 0xFFFFu, weights & 0xFFu);
    addJoint(sum, rest, joints01 >> 16u, (weights >> 8u) & 0xFFu);
    addJoint(sum, rest, joints23 & 0xFFFFu, (weights >> 16u) & 0xFFu);
    addJoint(sum, rest, joints23 >> 16u, weights >> 24u);
    return sum;
}

float irradiance(vec3 normal) {
    vec4 a = paletteRow(push.firstLight), b = paletteRow(push.firstLight + 1u);
    return irradianceOn(normal, a.xyz, vec3(a.w, b.xy), b.zw);
}

/** Irradiance on the posed normal over that at rest. */
float sceneLight(uint normal, uint joints01, uint joints23, uint weights) {
    vec3 rest = fromOctahedron(unpackSnorm2x16(normal));
    vec3 turned = skinned(vec4(rest, 0.0), joints01, joints23, weights);
    float size = length(turned);
    return irradiance(size > 1e-12 ? turned / size : vec3(0.0, 1.0, 0.0)) / irradiance(rest);
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint vertex = gl_WorkGroupID.x * kVertexGroup + lane;
    if (lane == 0u) {
        groupMax = 0u;
        groupMinInverted = 0u;
    }
    barrier();
    if (vertex < push.vertexCount && seen(vertex)) {
#ifdef DPL_CORRECTED
        CorrectedVertexRecord v = vertexAt(vertex);
        vec4 correction = nodeShare(v.nodes01 & 0xFFFFu, v.nodeWeights & 0xFFu) + nodeShare(v.nodes01 >> 16u, (v.nodeWeights >> 8u) & 0xFFu) +
                          nodeShare(v.nodes23 & 0xFFFFu, (v.nodeWeights >> 16u) & 0xFFu) + nodeShare(v.nodes23 >> 16u, v.nodeWeights >> 24u);
        vec4 rest = vec4(vec3(v.restX, v.restY, v.restZ) + correction.xyz, 1.0);
        float light = clamp(1.0 + correction.w, kGpuMinLight, kGpuMaxLight);
#else
        VertexRecord v = vertexAt(vertex);
        vec4 rest = vec4(v.restX, v.restY, v.restZ, 1.0);
        float light = 1.0;
#endif
        if (push.firstLight != 0u)
            light = clamp(light * sceneLight(v.normal, v.joints01, v.joints23, v.weights), kGpuMinLight, kGpuMaxLight);
        vec3 p = skinned(rest, v.joints01, v.joints23, v.weights);
        posed[vertex] = PosedVertex(p.x, p.y, p.z, light);
        vec3 sortAxis = vec3(frame.sortAxisX, frame.sortAxisY, frame.sortAxisZ);
        uint depth = dplOrderedBits(max(dot(sortAxis, p) + frame.sortOffsetM, frame.sortStartM));
        atomicMax(groupMax, depth);
        atomicMax(groupMinInverted, ~depth);
    }
    barrier();
    if (lane == 0u) {
        atomicMax(counts.depthMaxBits[push.drawn], groupMax);
        atomicMax(counts.depthMinBitsInverted[push.drawn], groupMinInverted);
    }
}
