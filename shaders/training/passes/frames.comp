// SPDX-License-Identifier: Apache-2.0
// Frames of the posed triangles: drawnTriangle() of sdk/math/binding.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "sdk/math/formulas/footprint.inl"
#include "sdk/math/formulas/pose.inl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) readonly buffer RestBlock { TrainRestTriangle rests[]; };
layout(std430, binding = 2) readonly buffer NowBlock { TrainRestInverse nows[]; };
layout(std430, binding = 3) readonly buffer PosedBlock { vec4 posed[]; };  // place, and brightness in w
layout(std430, binding = 4) writeonly buffer TriangleBlock { TrainTriangle triangles[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= frame.triangleCount) return;
    TrainRestTriangle rest = rests[i];
    TrainRestInverse now = nows[i];
    vec4 c0 = posed[rest.corner0], c1 = posed[rest.corner1], c2 = posed[rest.corner2];
    PosedTriangle t = posedTriangle(rest.i00, rest.i01, rest.i11, c0.xyz, c1.xyz, c2.xyz);
    PosedTriangle seen = posedTriangle(now.i00, now.i01, now.i11, c0.xyz, c1.xyz, c2.xyz);
    BoundedPlane plane = boundedPlane(seen.f0, seen.f1, seen.turned1, seen.turned2);
    bool valid = rest.valid != 0u && t.valid && plane.shown > 0.0;
    // As RestMap: F = F'·M, where F' is measured from `now`.
    float m00 = rest.i00 / now.i00, m11 = rest.i11 / now.i11, m01 = (rest.i01 - now.i01 * m11) / now.i00;
    vec3 f0 = plane.bounded ? m00 * plane.f0 : t.f0, f1 = plane.bounded ? m01 * plane.f0 + m11 * plane.f1 : t.f1;
    mat3 turned = mat3(t.turned1, t.turned2, t.normal) *
                  transpose(mat3(rest.t1X, rest.t1Y, rest.t1Z, rest.t2X, rest.t2Y, rest.t2Z, rest.normalX, rest.normalY, rest.normalZ));
    uint flags = (valid ? kTrainValid : 0u) | (plane.bounded ? kTrainBounded : 0u);
    triangles[i] = TrainTriangle(c0.x, c0.y, c0.z, plane.shown, c1.x, c1.y, c1.z, flags, c2.x, c2.y, c2.z, c0.w, f0.x, f0.y, f0.z, c1.w,
                                 f1.x, f1.y, f1.z, c2.w, t.normal.x, t.normal.y, t.normal.z, 0.0, turned[0].x, turned[0].y, turned[0].z, 0.0,
                                 turned[1].x, turned[1].y, turned[1].z, 0.0, turned[2].x, turned[2].y, turned[2].z, 0.0);
}
