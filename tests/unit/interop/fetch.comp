// SPDX-License-Identifier: Apache-2.0
// Reads all samples of a layer into a buffer.
#version 450
#extension GL_EXT_samplerless_texture_functions : require
layout(local_size_x = 64) in;
#ifdef FOUR
layout(binding = 0) uniform texture2DMSArray colours;
layout(binding = 1) uniform texture2DMSArray depths;
#else
layout(binding = 0) uniform texture2DArray colours;
layout(binding = 1) uniform texture2DArray depths;
#endif
layout(std430, binding = 2) writeonly buffer Samples { float values[]; };  // as in paint.frag
layout(push_constant) uniform Push { uint widthPx, samples, layer; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= widthPx) return;
    for (uint s = 0u; s < samples; ++s) {
        ivec3 texel = ivec3(pixel, layer);
        int lod = int(s);  // with one sample: level 0
        vec4 colour = texelFetch(colours, texel, lod);
        float depth = texelFetch(depths, texel, lod).r;
        uint at = 5u * ((pixel.y * widthPx + pixel.x) * samples + s);
        for (uint c = 0u; c < 4u; ++c) values[at + c] = colour[c];
        values[at + 4u] = depth;
    }
}
