// SPDX-License-Identifier: Apache-2.0
// Writes one sample of each pixel from a buffer.
#version 450
layout(std430, binding = 0) readonly buffer Samples { float values[]; };  // by pixel and sample: red, green, blue, alpha, depth
layout(push_constant) uniform Push { uint widthPx, samples, index; };
layout(location = 0) out vec4 colour;

void main() {
    uint at = 5u * ((uint(gl_FragCoord.y) * widthPx + uint(gl_FragCoord.x)) * samples + index);
    colour = vec4(values[at], values[at + 1u], values[at + 2u], values[at + 3u]);
    gl_FragDepth = values[at + 4u];
    gl_SampleMask[0] = 1 << int(index);
}
