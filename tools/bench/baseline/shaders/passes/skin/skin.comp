// SPDX-License-Identifier: Apache-2.0
// Poses every vertex with its four unorm8 weights.
// DPL_CORRECTED: the control nodes of the pose move the rest position first and give the vertex its brightness (sdk/avatar/pose_correctives.h).
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std430, binding = 0) readonly buffer PaletteBlock { vec4 palette[]; };  // three rows of G_j a joint, then a vec4 a control node
#ifdef DPL_CORRECTED
layout(std430, binding = 1) readonly buffer VertexBlock { CorrectedVertexRecord vertices[]; };
#else
layout(std430, binding = 1) readonly buffer VertexBlock { VertexRecord vertices[]; };
#endif
layout(std430, binding = 2) writeonly buffer PosedBlock { vec4 posed[]; };
layout(push_constant) uniform PushBlock { VertexPush push; };

void addJoint(inout vec3 sum, vec4 rest, uint joint, uint weight) {
    float w = float(weight) * (1.0 / 255.0);
    sum += w * vec3(dot(palette[joint * 3u], rest), dot(palette[joint * 3u + 1u], rest), dot(palette[joint * 3u + 2u], rest));
}

#ifdef DPL_CORRECTED
vec4 nodeShare(uint node, uint weight) { return float(weight) * (1.0 / 255.0) * palette[push.firstNode + node]; }
#endif

void main() {
    uint vertex = gl_GlobalInvocationID.x;
    if (vertex < push.vertexCount) {
#ifdef DPL_CORRECTED
        CorrectedVertexRecord v = vertices[vertex];
        vec4 correction = nodeShare(v.nodes01 & 0xFFFFu, v.nodeWeights & 0xFFu) + nodeShare(v.nodes01 >> 16u, (v.nodeWeights >> 8u) & 0xFFu) +
                          nodeShare(v.nodes23 & 0xFFFFu, (v.nodeWeights >> 16u) & 0xFFu) + nodeShare(v.nodes23 >> 16u, v.nodeWeights >> 24u);
        vec4 rest = vec4(vec3(v.restX, v.restY, v.restZ) + correction.xyz, 1.0);
        float light = clamp(1.0 + correction.w, kGpuMinLight, kGpuMaxLight);
#else
        VertexRecord v = vertices[vertex];
        vec4 rest = vec4(v.restX, v.restY, v.restZ, 1.0);
        const float light = 1.0;
#endif
        vec3 p = vec3(0.0);
        addJoint(p, rest, v.joints01 & 0xFFFFu, v.weights & 0xFFu);
        addJoint(p, rest, v.joints01 >> 16u, (v.weights >> 8u) & 0xFFu);
        addJoint(p, rest, v.joints23 & 0xFFFFu, (v.weights >> 16u) & 0xFFu);
        addJoint(p, rest, v.joints23 >> 16u, v.weights >> 24u);
        posed[vertex] = vec4(p, light);
    }
}
