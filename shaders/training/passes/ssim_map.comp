// SPDX-License-Identifier: Apache-2.0
// Ends the blur along columns. Sums the similarity S, and writes ∂S/∂(blurred x), ∂S/∂(blurred x²) and ∂S/∂(blurred xy).
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/window.glsl"
layout(local_size_x = 256) in;

layout(std430, binding = 1) readonly buffer BlurBlock { float blurred[]; };
layout(std430, binding = 2) writeonly buffer MapBlock { float maps[]; };  // [channel][derivative] planes
layout(std430, binding = 3) writeonly buffer SumBlock { float sums[]; };  // of the groups of loss.comp
#include "shaders/training/lib/sum.glsl"

float mapsOf(uint channel, uint pixel, uint pixels) {
    const float c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    int row = int(pixel / frame.widthPx), height = int(frame.heightPx), width = int(frame.widthPx);
    float v[5] = float[5](0.0, 0.0, 0.0, 0.0, 0.0);
    for (int k = -kWindowReach; k <= kWindowReach; ++k) {
        if (row + k < 0 || row + k >= height) continue;
        for (uint p = 0u; p < 5u; ++p) v[p] += kTap[k + kWindowReach] * blurred[(5u * channel + p) * pixels + uint(int(pixel) + k * width)];
    }
    float both = v[0] * v[1], xx = v[0] * v[0], yy = v[1] * v[1];
    float n1 = 2.0 * both + c1, n2 = 2.0 * (v[4] - both) + c2, d1 = xx + yy + c1, d2 = v[2] + v[3] - (xx + yy) + c2;
    float inverse = 1.0 / (d1 * d2), s = n1 * n2 * inverse, square = -(s / d2), cross_ = 2.0 * (n1 * inverse);
    float mean = 2.0 * (v[1] * (n2 * inverse) - v[0] * (s / d1)) - (2.0 * v[0] * square + v[1] * cross_);
    uint at = 3u * channel * pixels + pixel;
    maps[at] = mean;
    maps[at + pixels] = square;
    maps[at + 2u * pixels] = cross_;
    return s;
}

void main() {
    uint pixels = frame.widthPx * frame.heightPx, i = gl_GlobalInvocationID.x;
    float s = 0.0;
    if (i < pixels)
        for (uint channel = 0u; channel < 3u; ++channel) s += 1.0 - mapsOf(channel, i, pixels);
    float total = sumOfGroup(s);
    if (gl_LocalInvocationIndex == 0u) sums[gl_WorkGroupID.x * kTrainSums + 5u] = total;
}
