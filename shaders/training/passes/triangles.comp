// SPDX-License-Identifier: Apache-2.0
// Sums the parts of a triangle's splats, in their order, and finishes the gradients of its corners.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/binding.glsl"
#include "shaders/training/lib/backward.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) readonly buffer StartBlock { uint starts[]; };  // first splat of each triangle, and one past the last
layout(std430, binding = 2) readonly buffer ShownBlock { float shown[]; };
layout(std430, binding = 3) readonly buffer PartBlock { vec4 parts[]; };
layout(std430, binding = 4) readonly buffer TriangleBlock { TrainTriangle triangles[]; };
layout(std430, binding = 5) readonly buffer RestBlock { TrainRestTriangle rests[]; };
layout(std430, binding = 6) readonly buffer NowBlock { TrainRestInverse nows[]; };
layout(std430, binding = 7) writeonly buffer CornerBlock { vec4 corners[]; };  // three a triangle: gradients on place and brightness

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= frame.triangleCount) return;
    bool any = false;
    vec4 sum[kTrainTriangleFours];
    for (uint k = 0u; k < kTrainTriangleFours; ++k) sum[k] = vec4(0.0);
    for (uint splat = starts[i]; splat < starts[i + 1u]; ++splat) {
        if (shown[splat] < 0.0) continue;
        any = true;
        for (uint k = 0u; k < kTrainTriangleFours; ++k) sum[k] += parts[kTrainTriangleFours * splat + k];
    }
    vec3 c0 = sum[3].xyz, c1 = sum[4].xyz, c2 = sum[5].xyz;
    if (any) {
        TrainRestTriangle bind = rests[i];
        TrainRestInverse now = nows[i];
        PlaneGradient g;
        g.f0 = sum[0].xyz;
        g.f1 = sum[1].xyz;
        EdgeGradient edges = triangleBackward(triangleFrameOf(triangles[i]), RestEdges(bind.i00, bind.i01, bind.i11),
                                              RestEdges(now.i00, now.i01, now.i11), g, sum[2].xyz, sum[0].w);
        c0 -= edges.d1 + edges.d2;
        c1 += edges.d1;
        c2 += edges.d2;
    }
    corners[3u * i] = vec4(c0, sum[1].w);
    corners[3u * i + 1u] = vec4(c1, sum[2].w);
    corners[3u * i + 2u] = vec4(c2, sum[3].w);
}
