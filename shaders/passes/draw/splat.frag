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

layout(location = 0) flat in vec4 centreConic;  // packed by splat.vert
layout(location = 1) flat in vec4 conicOpacity;
layout(location = 2) flat in vec4 colourDepth;
layout(location = 0) out vec4 colour;
#ifdef DPL_DEPTH
layout(location = 1) out vec4 depthSums;
#endif

void main() {
#ifdef DPL_SCENE_DEPTH
    uint x = uint(gl_FragCoord.x), row = uint(conicOpacity.z) * uint(push.targetHeightPx) + uint(gl_FragCoord.y);
    if (colourDepth.w > scene[row * uint(push.targetWidthPx) + x]) discard;
#endif
    vec2 d = gl_FragCoord.xy - centreConic.xy;
    // exp(-σ): the vertex shader scaled the conic for exp2.
    float alpha = min(kMaxAlpha, conicOpacity.y * exp2(d.x * (centreConic.z * d.x + centreConic.w * d.y) + conicOpacity.x * d.y * d.y));
    if (!(alpha >= kMinAlpha)) discard;
    colour = vec4(colourDepth.rgb * alpha, alpha);
#ifdef DPL_DEPTH
    depthSums = vec4(colourDepth.w * alpha, alpha, 0.0, alpha);
#endif
}
