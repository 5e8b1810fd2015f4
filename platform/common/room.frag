// SPDX-License-Identifier: Apache-2.0
// Light of the room, linear, at most 1. Far things fade into the backdrop.
#version 450
layout(constant_id = 0) const bool kBright = false;
layout(location = 0) in vec3 world;
layout(location = 1) in vec3 normal;
layout(location = 2) in float open;
layout(location = 3) flat in int surface;  // RoomSurface
layout(location = 0) out vec4 colour;

/** The backdrop from the floor (0) to its top (1). */
vec3 backdrop(float height) {
    height = max(height, 0.0);  // at an edge, four samples extrapolate
    return kBright ? mix(vec3(0.60, 0.62, 0.65), vec3(0.30, 0.42, 0.58), pow(height, 0.8))
                   : mix(vec3(0.022, 0.028, 0.042), vec3(0.002, 0.003, 0.007), pow(height, 0.5));
}

/** How much of a pixel the lines of a grid cover. Lines closer than two pixels become an even tone. */
float gridLines(vec2 metres, float spacing, float width) {
    vec2 at = metres / spacing, footprint = max(fwidth(at), vec2(1e-6));
    vec2 toLine = abs(fract(at - 0.5) - 0.5);
    vec2 reach = 0.5 * vec2(width / spacing) + 0.5 * footprint;
    vec2 covered = clamp((reach - toLine) / footprint, 0.0, 1.0) * min(vec2(1), width / spacing / footprint);
    vec2 line = mix(covered, vec2(width / spacing), smoothstep(0.3, 0.7, footprint));
    return max(line.x, line.y);
}

void main() {
    float fromAxis = length(world.xz);
    if (surface == 1) {
        colour = vec4(backdrop(open), 1);
        return;
    }
    vec3 n = normalize(normal), albedo, sky, key;
    vec3 toKey = normalize(vec3(1.6, 3.4, 2.6) - world * vec3(0.6, 0.6, 0.6)), toRim = normalize(vec3(-4.0, 2.0, -3.0) - world * 0.4);
    vec3 rim;
    if (kBright) {
        albedo = surface == 0 ? vec3(0.62, 0.61, 0.60) : surface == 2 ? vec3(0.78, 0.76, 0.72) : vec3(0.80, 0.80, 0.80);
        sky = mix(vec3(0.42, 0.41, 0.40), vec3(0.60, 0.63, 0.68), 0.5 + 0.5 * n.y);
        key = vec3(0.50, 0.47, 0.42), rim = vec3(0.10, 0.12, 0.15);
        if (surface == 0) albedo *= 1.0 - 0.30 * gridLines(world.xz, 1.0, 0.012) - 0.12 * gridLines(world.xz, 0.25, 0.006);
    } else {
        albedo = surface == 0 ? vec3(0.085, 0.095, 0.115) : surface == 2 ? vec3(0.30, 0.28, 0.26) : vec3(0.17, 0.18, 0.20);
        sky = mix(vec3(0.05, 0.05, 0.06), vec3(0.13, 0.15, 0.20), 0.5 + 0.5 * n.y);
        float pool = exp(-fromAxis * fromAxis / 26.0);
        key = vec3(1.10, 0.96, 0.78) * (0.12 + 0.88 * pool), rim = vec3(0.16, 0.26, 0.42);
        if (surface == 0) albedo += vec3(0.08, 0.13, 0.17) * (0.9 * gridLines(world.xz, 1.0, 0.014) + 0.35 * gridLines(world.xz, 0.25, 0.006));
    }
    vec3 light = sky + key * max(dot(n, toKey), 0.0) + rim * max(dot(n, toRim), 0.0);
    float far = smoothstep(4.0, 14.0, fromAxis);
    colour = vec4(min(mix(albedo * light * open, backdrop(0), far), vec3(1)), 1);
}
