// One quad a survivor and view, far first: the box outside which the splat is below 1/255, cut to the view.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/footprint.glsl"
#include "shaders/lib/projected.glsl"
#include "shaders/lib/view.glsl"

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
DPL_WORDS(1, OrderBlock, order);
DPL_FOURS(2, ProjectedBlock, projected);  // ProjectedSplat
layout(push_constant) uniform PushBlock { DrawPush push; };

layout(location = 0) flat out vec4 centreConic;   // centre px, conic A and B
layout(location = 1) flat out vec4 conicOpacity;  // conic C, opacity, view, 0
layout(location = 2) flat out vec4 colourDepth;   // rgb, view z

void main() {
    uint view = dplViewIndex(push.view);
    // The order is near first with ties in splat order; drawing it backwards gives the exact mirror of front-to-back blending.
    uint splat = DPL_WORD(order, counts.visible - 1u - dplQuad()), record = 3u * (splat * push.viewCount + view);
    ProjectedSplat p;
    p.place = dplFloats(DPL_FOUR(projected, record));
    p.look = DPL_FOUR(projected, record + 1u);
    p.radiusPx = dplFloats(DPL_FOUR(projected, record + 2u)).xy;
    centreConic = p.place;
    conicOpacity = vec4(uintBitsToFloat(p.look.x), dplOpacityOf(p), float(view), 0.0);
    colourDepth = vec4(dplUnpackColour(p.look.z), uintBitsToFloat(p.look.w));
    vec2 size = vec2(push.targetWidthPx, push.targetHeightPx);
    vec2 low = clamp(p.place.xy - p.radiusPx, vec2(0.0), size), high = clamp(p.place.xy + p.radiusPx, vec2(0.0), size);
    uint corner = dplCorner();
    vec2 px = vec2((corner & 1u) != 0u ? high.x : low.x, (corner & 2u) != 0u ? high.y : low.y);
    vec2 ndc = 2.0 * px / size - 1.0;
    gl_Position = p.radiusPx.y > 0.0 ? vec4(ndc, 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}
