// SPDX-License-Identifier: Apache-2.0
// One posed frame a triangle: corners, the columns of F, the unit normal and the polar rotation (sdk/math/binding.h).
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std430, binding = 0) readonly buffer TriangleBlock { TriangleRecord triangles[]; };
layout(std430, binding = 1) readonly buffer PosedBlock { vec4 posed[]; };
layout(std430, binding = 2) writeonly buffer FrameBlock { TriangleFrame frames[]; };
layout(push_constant) uniform PushBlock { TrianglePush push; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.triangleCount) return;
    TriangleRecord rest = triangles[index];
    vec4 corner0 = posed[rest.corners.x], corner1 = posed[rest.corners.y], corner2 = posed[rest.corners.z];  // w: brightness
    vec3 v0 = corner0.xyz, v1 = corner1.xyz, v2 = corner2.xyz;
    TriangleFrame f;
    f.v0 = vec4(v0, 0.0);
    f.v1 = vec4(v1, 0.0);
    f.v2 = vec4(v2, 0.0);
    f.f0 = f.f1 = f.worldFromRest0 = f.worldFromRest1 = f.worldFromRest2 = vec4(0.0);
    vec3 d1 = v1 - v0, d2 = v2 - v0, d3 = v2 - v1;
    vec3 normal = cross(d1, d2);
    float doubleArea = length(normal);
    float longest2 = max(dot(d1, d1), max(dot(d2, d2), dot(d3, d3)));
    if (rest.corners.w != 0u && doubleArea > 2.0 * kGpuMinTriangleAreaM2 && longest2 < kGpuMaxTriangleAspect * doubleArea) {
        vec3 f0 = d1 * rest.restT1.w;
        vec3 f1 = d1 * rest.restT2.w + d2 * rest.restNormal.w;
        normal /= doubleArea;
        // Polar rotation of the 2×2 map between the frames. t1 runs along d1, so m10 = t2·F0 = 0.
        vec3 t1 = normalize(d1), t2 = cross(normal, t1);
        float sine = -dot(t1, f1), cosine = dot(t1, f0) + dot(t2, f1);
        float radius = sqrt(sine * sine + cosine * cosine);
        float c = radius > 1e-12 ? cosine / radius : 1.0, s = radius > 1e-12 ? sine / radius : 0.0;
        mat3 turned = mat3(c * t1 + s * t2, c * t2 - s * t1, normal);
        mat3 worldFromRest = turned * transpose(mat3(rest.restT1.xyz, rest.restT2.xyz, rest.restNormal.xyz));
        f.v0.w = 1.0;
        f.v1.w = normal.x;
        f.v2.w = normal.y;
        f.f0 = vec4(f0, normal.z);
        f.f1 = vec4(f1, 0.0);
        f.worldFromRest0 = vec4(worldFromRest[0], corner0.w);
        f.worldFromRest1 = vec4(worldFromRest[1], corner1.w);
        f.worldFromRest2 = vec4(worldFromRest[2], corner2.w);
    }
    frames[index] = f;
}
