// SPDX-License-Identifier: Apache-2.0
// Poses every vertex with its four joints (unorm8 weights) and keeps the extent along the sort axis, which is the range of the depth
// keys. A vertex of components that no view sees is not written, because no pass reads it in this frame.
// DPL_CORRECTED: first moves the rest position by the control nodes of the pose, and writes the vertex's brightness
// (sdk/avatar/pose_correctives.h).
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/order.glsl"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
DPL_FOURS(1, PaletteBlock, palette);  // three rows of G_j for each joint, then one vec4 for each control node
DPL_FOURS(2, VertexBlock, vertices);  // VertexRecord; DPL_CORRECTED: CorrectedVertexRecord
layout(std430, binding = 3) writeonly buffer PosedBlock { vec4 posed[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { VertexPush push; };

shared uint groupMax;
shared uint groupMinInverted;

vec4 paletteRow(uint row) { return dplFloats(DPL_FOUR(palette, row)); }

void addJoint(inout vec3 sum, vec4 rest, uint joint, uint weight) {
    float w = float(weight) * (1.0 / 255.0);
    sum += w * vec3(dot(paletteRow(joint * 3u), rest), dot(paletteRow(joint * 3u + 1u), rest), dot(paletteRow(joint * 3u + 2u), rest));
}

bool seen(uint vertex) {
    if (frame.unseenComponents == 0u) return true;
#ifdef DPL_CORRECTED
    return (DPL_FOUR(vertices, 3u * vertex + 2u).y & ~frame.unseenComponents) != 0u;
#else
    return (DPL_FOUR(vertices, 2u * vertex + 1u).z & ~frame.unseenComponents) != 0u;
#endif
}

#ifdef DPL_CORRECTED
vec4 nodeShare(uint node, uint weight) { return float(weight) * (1.0 / 255.0) * paletteRow(push.firstNode + node); }
#endif

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
        uvec4 place = DPL_FOUR(vertices, 3u * vertex), joints = DPL_FOUR(vertices, 3u * vertex + 1u);  // restX, restY, restZ, joints01 | joints23, weights, nodes01, nodes23 | nodeWeights
        uint weights = joints.y, nodeWeights = DPL_FOUR(vertices, 3u * vertex + 2u).x;
        vec4 correction = nodeShare(joints.z & 0xFFFFu, nodeWeights & 0xFFu) + nodeShare(joints.z >> 16u, (nodeWeights >> 8u) & 0xFFu) +
                          nodeShare(joints.w & 0xFFFFu, (nodeWeights >> 16u) & 0xFFu) + nodeShare(joints.w >> 16u, nodeWeights >> 24u);
        vec4 rest = vec4(dplFloats(place).xyz + correction.xyz, 1.0);
        float light = clamp(1.0 + correction.w, kGpuMinLight, kGpuMaxLight);
#else
        uvec4 place = DPL_FOUR(vertices, 2u * vertex), joints = DPL_FOUR(vertices, 2u * vertex + 1u);  // restX, restY, restZ, joints01 | joints23, weights
        uint weights = joints.y;
        vec4 rest = vec4(dplFloats(place).xyz, 1.0);
        const float light = 1.0;
#endif
        vec3 p = vec3(0.0);
        addJoint(p, rest, place.w & 0xFFFFu, weights & 0xFFu);
        addJoint(p, rest, place.w >> 16u, (weights >> 8u) & 0xFFu);
        addJoint(p, rest, joints.x & 0xFFFFu, (weights >> 16u) & 0xFFu);
        addJoint(p, rest, joints.x >> 16u, weights >> 24u);
        posed[vertex] = vec4(p, light);
        uint depth = dplOrderedBits(max(dot(frame.sortAxis, p), frame.sortStartM));
        atomicMax(groupMax, depth);
        atomicMax(groupMinInverted, ~depth);
    }
    barrier();
    if (lane == 0u) {
        atomicMax(counts.depthMaxBits[push.drawn], groupMax);
        atomicMax(counts.depthMinBitsInverted[push.drawn], groupMinInverted);
    }
}
