// SPDX-License-Identifier: Apache-2.0
// Compares a picture with its target (docs/reference/losses.md): sums of the loss, the two pictures that SSIM compares, and what the terms
// other than SSIM add to the gradient of each pixel.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
layout(local_size_x = 256) in;

layout(std430, binding = 1) readonly buffer ImageBlock { vec4 image[]; };
layout(std430, binding = 2) readonly buffer ClothBlock { float cloths[]; };
layout(std430, binding = 3) readonly buffer TargetBlock { uint targets[]; };
layout(std430, binding = 4) writeonly buffer PlaneBlock { float planes[]; };      // three of what is drawn, three of what is wanted
layout(std430, binding = 5) writeonly buffer GradientBlock { vec4 gradients[]; };  // two a pixel: (colour, alpha), (cloth, shares, -)
layout(std430, binding = 6) writeonly buffer SumBlock { float sums[]; };
#include "shaders/training/lib/sum.glsl"
#include "shaders/training/lib/target.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x, pixels = frame.widthPx * frame.heightPx;
    float own[kTrainSums];
    for (uint k = 0u; k < kTrainSums; ++k) own[k] = 0.0;
    if (i < pixels) {
        vec4 drawnColour = image[i];
        float alpha = 1.0 - drawnColour.w;
        TargetPixel t = targetAt(i);
        vec3 drawn = drawnColour.rgb + drawnColour.w * t.behind, wanted = t.colour + (1.0 - t.shown) * frame.background.rgb;
        vec3 error = drawn - wanted, colourGradient = frame.l1Step * sign(error);
        for (uint c = 0u; c < 3u; ++c) {
            planes[c * pixels + i] = drawn[c];
            planes[(3u + c) * pixels + i] = wanted[c];
            own[0] += abs(error[c]);
        }
        if (t.mask >= 0.5) {
            own[3] = dot(error, error);
            own[4] = 3.0;
        }
        float maskError = alpha - t.mask, maskWeight = 1.0 + (frame.edgeMaskWeight - 1.0) * t.unsure;
        own[1] = maskWeight * abs(maskError);
        float clothGradient = 0.0;
        vec2 shares = vec2(1.0);
        if (frame.clothStep > 0.0) {
            float clothError = cloths[i] - t.cloth;
            own[2] = abs(clothError);
            clothGradient = frame.clothStep * sign(clothError);
            shares = vec2(1.0 - t.cloth, 1.0 - max(0.0, t.mask - t.cloth));
        }
        gradients[2u * i] = vec4(colourGradient, frame.maskStep * maskWeight * sign(maskError));
        gradients[2u * i + 1u] = vec4(clothGradient, shares, 0.0);
    }
    for (uint k = 0u; k < 5u; ++k) {
        float total = sumOfGroup(own[k]);
        if (gl_LocalInvocationIndex == 0u) sums[gl_WorkGroupID.x * kTrainSums + k] = total;
    }
}
