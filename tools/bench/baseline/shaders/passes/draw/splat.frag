// SPDX-License-Identifier: Apache-2.0
// α of one splat at one pixel, premultiplied; the depth target collects Σ α T z and Σ α T.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(push_constant) uniform PushBlock { DrawPush push; };

layout(location = 0) flat in vec4 centreConic;
layout(location = 1) flat in vec4 conicOpacity;
layout(location = 2) flat in vec4 colourDepth;
layout(location = 0) out vec4 colour;
#ifdef DPL_DEPTH
layout(location = 1) out vec4 depthSums;
#endif

void main() {
    vec2 d = gl_FragCoord.xy - vec2(conicOpacity.z * push.targetWidthPx, 0.0) - centreConic.xy;
    float sigma = 0.5 * (centreConic.z * d.x * d.x + conicOpacity.x * d.y * d.y) + centreConic.w * d.x * d.y;
    float alpha = min(kGpuMaxAlpha, conicOpacity.y * exp(-sigma));
    if (!(sigma >= 0.0) || alpha < kGpuMinAlpha) discard;
    colour = vec4(colourDepth.rgb * alpha, alpha);
#ifdef DPL_DEPTH
    depthSums = vec4(colourDepth.w * alpha, alpha, 0.0, alpha);
#endif
}
