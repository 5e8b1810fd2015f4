// SPDX-License-Identifier: Apache-2.0
// Reads a view of a target back as 8-bit codes, the last one the transmittance. For Metal, whose copies do not convert formats.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shaders/shared/frame.h"
layout(local_size_x = 64) in;  // kSceneGroup

layout(binding = 0) uniform texture2DArray drawn;
layout(std430, binding = 1) writeonly buffer CodeBlock { uint codes[]; };
layout(push_constant) uniform PushBlock { RoundPush push; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= push.widthPx) return;
    uvec4 code = uvec4(floor(clamp(texelFetch(drawn, ivec3(pixel, push.layer), 0), 0.0, 1.0) * 255.0 + 0.5));
    codes[push.firstPixel + pixel.y * push.widthPx + pixel.x] = code.r | code.g << 8u | code.b << 16u | code.a << 24u;
}
