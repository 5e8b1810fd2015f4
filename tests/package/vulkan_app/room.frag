// SPDX-License-Identifier: Apache-2.0
// Linear light of a lamp and of the sky, brighter than white near the lamp.
#version 450
layout(location = 0) in vec3 world;
layout(location = 1) flat in vec3 normal;
layout(location = 2) flat in vec3 albedo;
layout(location = 0) out vec4 colour;
void main() {
    vec3 toLamp = vec3(0.6, 2.4, 1.6) - world;
    float falloff = 3.5 * max(dot(normal, normalize(toLamp)), 0.0) / dot(toLamp, toLamp);
    float checker = normal.y > 0.5 ? 0.8 + 0.4 * mod(floor(world.x) + floor(world.z), 2.0) : 1.0;
    colour = vec4(albedo * checker * (vec3(0.12, 0.13, 0.16) + falloff * vec3(1.0, 0.92, 0.8)), 1.0);
}
