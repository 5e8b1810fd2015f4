// SPDX-License-Identifier: Apache-2.0
// Sums the gradients of a vertex over its corners, in the order of its triangles.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) readonly buffer OffsetBlock { uint offsets[]; };   // first corner of each vertex, and one past the last
layout(std430, binding = 2) readonly buffer CornerOfBlock { uint cornersOf[]; };
layout(std430, binding = 3) readonly buffer CornerBlock { vec4 corners[]; };
layout(std430, binding = 4) writeonly buffer VertexBlock { vec4 vertices[]; };  // gradients on place and brightness

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= frame.vertexCount) return;
    vec4 sum = vec4(0.0);
    for (uint k = offsets[i]; k < offsets[i + 1u]; ++k) sum += corners[cornersOf[k]];
    vertices[i] = sum;
}
