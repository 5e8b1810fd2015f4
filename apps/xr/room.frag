// SPDX-License-Identifier: Apache-2.0
// Linear light of a lamp above the user and of the sky. The floor has a grid with a line each half metre.
#version 450
layout(location = 0) in vec3 world;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec3 albedo;
layout(location = 0) out vec4 colour;
void main() {
    vec3 toLamp = vec3(0.8, 2.6, -0.6) - world;
    float falloff = 2.5 * max(dot(normal, normalize(toLamp)), 0.0) / dot(toLamp, toLamp);
    vec2 fromLine = abs(fract(2.0 * world.xz - 0.5) - 0.5), width = fwidth(2.0 * world.xz);
    float line = normal.y > 0.5 ? 1.0 - min(min(fromLine.x / width.x, fromLine.y / width.y), 1.0) : 0.0;
    vec3 surface = mix(albedo, vec3(0.08), 0.7 * line);
    colour = vec4(surface * (vec3(0.16, 0.17, 0.2) + falloff * vec3(1.0, 0.92, 0.8)), 1.0);
}
