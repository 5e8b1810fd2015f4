// Poses every vertex with its four unorm8 weights and keeps the posed extent along the sort axis, the range of the depth keys.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/order.glsl"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer PaletteBlock { vec4 palette[]; };  // three rows of G_j a joint
layout(std430, binding = 2) readonly buffer VertexBlock { VertexRecord vertices[]; };
layout(std430, binding = 3) writeonly buffer PosedBlock { vec4 posed[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { VertexPush push; };

shared uint groupMax;
shared uint groupMinInverted;

void addJoint(inout vec3 sum, vec4 rest, uint joint, uint weight) {
    float w = float(weight) * (1.0 / 255.0);
    sum += w * vec3(dot(palette[joint * 3u], rest), dot(palette[joint * 3u + 1u], rest), dot(palette[joint * 3u + 2u], rest));
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint vertex = gl_WorkGroupID.x * kVertexGroup + lane;
    if (lane == 0u) {
        groupMax = 0u;
        groupMinInverted = 0u;
    }
    barrier();
    if (vertex < push.vertexCount) {
        VertexRecord v = vertices[vertex];
        vec4 rest = vec4(v.restX, v.restY, v.restZ, 1.0);
        vec3 p = vec3(0.0);
        addJoint(p, rest, v.joints01 & 0xFFFFu, v.weights & 0xFFu);
        addJoint(p, rest, v.joints01 >> 16u, (v.weights >> 8u) & 0xFFu);
        addJoint(p, rest, v.joints23 & 0xFFFFu, (v.weights >> 16u) & 0xFFu);
        addJoint(p, rest, v.joints23 >> 16u, v.weights >> 24u);
        posed[vertex] = vec4(p, 1.0);
        uint depth = dplOrderedBits(dot(frame.sortAxis.xyz, p));
        atomicMax(groupMax, depth);
        atomicMax(groupMinInverted, ~depth);
    }
    barrier();
    if (lane == 0u) {
        atomicMax(counts.depthMaxBits, groupMax);
        atomicMax(counts.depthMinBitsInverted, groupMinInverted);
    }
}
