// SPDX-License-Identifier: Apache-2.0
// One quad a survivor and view, far first: the box outside which the splat is below 1/255, cut to the view.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
#include "tools/bench/baseline/shaders/lib/view.glsl"

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 1) readonly buffer PairBlock { uvec2 pairs[]; };
layout(std430, binding = 2) readonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(push_constant) uniform PushBlock { DrawPush push; };

layout(location = 0) flat out vec4 centreConic;   // centre px, conic A and B
layout(location = 1) flat out vec4 conicOpacity;  // conic C, opacity, view column, unused
layout(location = 2) flat out vec4 colourDepth;   // rgb, view z

void main() {
    uint view = dplViewIndex(push.viewCount);
    // Pairs are near first with ties in splat order; drawing them backwards gives the exact mirror of front-to-back blending.
    uvec2 pair = pairs[counts.visible - 1u - dplSplatInstance(push.viewCount)];
    uint splat = pair.y;
    ProjectedSplat p = projected[splat * push.viewCount + view];
    float column = push.atlasColumns > 1u ? float(view) : 0.0;
    centreConic = vec4(p.centrePx, p.conicA, p.conicB);
    conicOpacity = vec4(p.conicC, p.opacity, column, 0.0);
    colourDepth = p.colour;
    vec2 size = vec2(push.targetWidthPx, push.targetHeightPx);
    vec2 low = clamp(p.centrePx - p.radiusPx, vec2(0.0), size), high = clamp(p.centrePx + p.radiusPx, vec2(0.0), size);
    vec2 px = vec2((gl_VertexIndex & 1) != 0 ? high.x : low.x, (gl_VertexIndex & 2) != 0 ? high.y : low.y);
    px.x += column * push.targetWidthPx;
    vec2 ndc = 2.0 * px / vec2(push.targetWidthPx * float(push.atlasColumns), push.targetHeightPx) - 1.0;
    gl_Position = p.opacity > 0.0 ? vec4(ndc, 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}
