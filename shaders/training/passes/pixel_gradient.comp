// SPDX-License-Identifier: Apache-2.0
// Ends the blur of the derivatives along columns, and leaves what the backward pass of the blend reads of a pixel: the gradient on colour
// and cover, the shares, and g·out, the part of the gradient that all its splats share.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/window.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) readonly buffer PlaneBlock { float planes[]; };
layout(std430, binding = 2) readonly buffer BlurBlock { float blurred[]; };
layout(std430, binding = 3) readonly buffer ImageBlock { vec4 image[]; };
layout(std430, binding = 4) readonly buffer ClothBlock { float cloths[]; };
layout(std430, binding = 5) readonly buffer TargetBlock { uint targets[]; };
layout(std430, binding = 6) buffer GradientBlock { vec4 gradients[]; };  // becomes (colour, cover of the body), (cover of cloth, shares, g·out)
#include "shaders/training/lib/target.glsl"

float blurredAt(uint plane, uint pixel, uint pixels) {
    int row = int(pixel / frame.widthPx), height = int(frame.heightPx), width = int(frame.widthPx);
    float sum = 0.0;
    for (int k = -kWindowReach; k <= kWindowReach; ++k)
        if (row + k >= 0 && row + k < height) sum += kTap[k + kWindowReach] * blurred[plane * pixels + uint(int(pixel) + k * width)];
    return sum;
}

void main() {
    uint pixels = frame.widthPx * frame.heightPx, i = gl_GlobalInvocationID.x;
    if (i >= pixels) return;
    vec4 colourAndAlpha = gradients[2u * i], rest = gradients[2u * i + 1u], drawn = image[i];
    vec3 colour = colourAndAlpha.rgb;
    if (frame.ssimStep != 0.0)
        for (uint c = 0u; c < 3u; ++c) {
            float x = planes[c * pixels + i], y = planes[(3u + c) * pixels + i];
            colour[c] += frame.ssimStep * (blurredAt(3u * c, i, pixels) + 2.0 * x * blurredAt(3u * c + 1u, i, pixels) +
                                           y * blurredAt(3u * c + 2u, i, pixels));
        }
    float cover = colourAndAlpha.w - dot(colour, targetAt(i).behind), cloth = rest.x;
    float shared_ = dot(colour, drawn.rgb) + cover * (1.0 - drawn.w) + cloth * cloths[i];
    gradients[2u * i] = vec4(colour, cover);
    gradients[2u * i + 1u] = vec4(cover + cloth, rest.yz, shared_);
}
