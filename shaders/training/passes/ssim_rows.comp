// SPDX-License-Identifier: Apache-2.0
// Blurs x, y, x², y² and xy along rows, for each channel; x is drawn, y is wanted.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/window.glsl"
layout(local_size_x = 256) in;

layout(std430, binding = 1) readonly buffer PlaneBlock { float planes[]; };
layout(std430, binding = 2) writeonly buffer BlurBlock { float blurred[]; };  // [channel][product] planes

void main() {
    uint pixels = frame.widthPx * frame.heightPx, i = gl_GlobalInvocationID.x;
    if (i >= 3u * pixels) return;
    uint channel = i / pixels, pixel = i % pixels;
    int column = int(pixel % frame.widthPx), width = int(frame.widthPx);
    float sums[5] = float[5](0.0, 0.0, 0.0, 0.0, 0.0);
    for (int k = -kWindowReach; k <= kWindowReach; ++k) {
        if (column + k < 0 || column + k >= width) continue;
        uint at = channel * pixels + uint(int(pixel) + k);
        float x = planes[at], y = planes[3u * pixels + at], w = kTap[k + kWindowReach];
        sums[0] += w * x;
        sums[1] += w * y;
        sums[2] += w * x * x;
        sums[3] += w * y * y;
        sums[4] += w * x * y;
    }
    for (uint k = 0u; k < 5u; ++k) blurred[(5u * channel + k) * pixels + pixel] = sums[k];
}
