// SPDX-License-Identifier: Apache-2.0
// Blurs the derivatives of the similarity along rows.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/window.glsl"
layout(local_size_x = 256) in;

layout(std430, binding = 1) readonly buffer MapBlock { float maps[]; };
layout(std430, binding = 2) writeonly buffer BlurBlock { float blurred[]; };  // nine planes

void main() {
    uint pixels = frame.widthPx * frame.heightPx, i = gl_GlobalInvocationID.x;
    if (i >= 9u * pixels) return;
    uint pixel = i % pixels;
    int column = int(pixel % frame.widthPx), width = int(frame.widthPx);
    float sum = 0.0;
    for (int k = -kWindowReach; k <= kWindowReach; ++k)
        if (column + k >= 0 && column + k < width) sum += kTap[k + kWindowReach] * maps[uint(int(i) + k)];
    blurred[i] = sum;
}
