// SPDX-License-Identifier: Apache-2.0
// Composes the picture of a view over an app's target, by the formulas of sdk/api/compose.h. The fixed blending of the pass does "over";
// for a target that encodes sRGB it decodes and encodes too. Where the picture is empty, the target keeps its bits.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shaders/shared/frame.h"
#include "shaders/lib/view.glsl"
#include "shaders/lib/srgb.glsl"

// Colour as quads draw it, and as tiles do. The views of a canted pair are two frames, so each view has its own image and buffer.
layout(binding = 0) uniform texture2DArray drawn0;
layout(binding = 1) uniform texture2DArray drawn1;
layout(std430, binding = 2) readonly buffer Tiled0Block { uint tiled0[]; };
layout(std430, binding = 3) readonly buffer Tiled1Block { uint tiled1[]; };
layout(std430, binding = 4) readonly buffer Counts0Block { FrameCounts counts0; };
layout(std430, binding = 5) readonly buffer Counts1Block { FrameCounts counts1; };
layout(push_constant) uniform PushBlock { ComposePush push; };
layout(location = 0) out vec4 colour;

void main() {
    uint view = dplViewIndex(push.view);
    bool second = view == 1u;
    ivec2 at = ivec2(gl_FragCoord.xy - vec2(push.placeX, push.placeY));
    uint drawnLayer = second ? push.drawnLayers >> 16 : push.drawnLayers & 0xFFFFu;
    uint tiledLayer = second ? push.tiledLayers >> 16 : push.tiledLayers & 0xFFFFu;
    vec4 picture;
    uint overflowed = second ? counts1.tilesOverflowed : counts0.tilesOverflowed;
    if ((push.tiled >> view & 1u) != 0u && overflowed == 0u) {
        uint pixel = (tiledLayer * push.heightPx + uint(at.y)) * push.widthPx + uint(at.x);
        picture = unpackUnorm4x8(second ? tiled1[pixel] : tiled0[pixel]);
    } else {
        ivec3 texel = ivec3(at, int(drawnLayer));
        picture = second ? texelFetch(drawn1, texel, 0) : texelFetch(drawn0, texel, 0);
        picture = floor(clamp(picture, 0.0, 1.0) * 255.0 + 0.5) / 255.0;  // 8 bits, as the picture that is read back
    }
    if (picture.a == 0.0) discard;
    if (push.linear != 0u) picture.rgb = dplLinearFromSrgb(min(picture.rgb / picture.a, vec3(1.0))) * picture.a;
    colour = picture;
}
