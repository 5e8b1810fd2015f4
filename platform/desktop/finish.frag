// SPDX-License-Identifier: Apache-2.0
// Encodes linear light by the sRGB curve, for a picture of display values.
#version 450
layout(binding = 0) uniform sampler2D linearLight;
layout(location = 0) out vec4 colour;
void main() {
    vec3 light = clamp(texelFetch(linearLight, ivec2(gl_FragCoord.xy), 0).rgb, 0.0, 1.0);
    colour = vec4(mix(12.92 * light, 1.055 * pow(light, vec3(1 / 2.4)) - 0.055, greaterThan(light, vec3(0.0031308))), 1);
}
