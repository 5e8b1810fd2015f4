// SPDX-License-Identifier: Apache-2.0
// α of one splat at one pixel, premultiplied. The depth target collects Σ α T z and Σ α T.
// DPL_SCENE_DEPTH: a splat behind the app's scene adds nothing. All samples of a pixel use one scene depth.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "sdk/math/formulas/constants.h"
layout(push_constant) uniform PushBlock { DrawPush push; };

#ifdef DPL_SCENE_DEPTH
// view z, infinite where the scene is empty; numbered after the bindings of the vertex shader
layout(std430, binding = 3) readonly buffer SceneBlock { float scene[]; };
#endif

layout(location = 0) flat in vec4 centreConic;  // packed by splat.vert; main() names the lanes
layout(location = 1) flat in vec4 conicOpacity;
layout(location = 2) flat in vec4 colourDepth;
layout(location = 0) out vec4 colour;
#ifdef DPL_DEPTH
layout(location = 1) out vec4 depthSums;
#endif

void main() {
    vec2 centrePx = centreConic.xy;
    float halfA = centreConic.z, b = centreConic.w, halfC = conicOpacity.x;  // the conic, scaled so that exp(-σ) is an exp2
    float opacity = conicOpacity.y, view = conicOpacity.z, depthM = colourDepth.w;
#ifdef DPL_SCENE_DEPTH
    uint x = uint(gl_FragCoord.x), row = uint(view) * uint(push.targetHeightPx) + uint(gl_FragCoord.y);
    if (depthM > scene[row * uint(push.targetWidthPx) + x]) discard;
#endif
    vec2 d = gl_FragCoord.xy - centrePx;
    float alpha = min(kMaxAlpha, opacity * exp2(d.x * (halfA * d.x + b * d.y) + halfC * d.y * d.y));
    if (!(alpha >= kMinAlpha)) discard;
    colour = vec4(colourDepth.rgb * alpha, alpha);
#ifdef DPL_DEPTH
    depthSums = vec4(depthM * alpha, alpha, 0.0, alpha);
#endif
}
