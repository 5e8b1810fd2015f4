// SPDX-License-Identifier: Apache-2.0
// A room of boxes: floor, back wall, three columns and a pane of glass. Each instance is a box, each three vertices a triangle.
#version 450
layout(push_constant) uniform Push {
    vec4 viewRow0, viewRow1, viewRow2;  // [R | t], x right, y down, z forward
    vec4 lens;                          // 2 fx / width, 2 fy / height, 2 cx / width - 1, 2 cy / height - 1
    float near;
} push;
layout(location = 0) out vec3 world;
layout(location = 1) flat out vec3 normal;
layout(location = 2) flat out vec3 albedo;

const vec3 kLow[6] = vec3[](vec3(-4, -0.1, -4), vec3(-4, 0, -4.1), vec3(-1.15, 0, 0.5),
                               vec3(-0.15, 0, -1.2), vec3(0.75, 0, 0.45), vec3(-0.95, 0.5, 0.29));
const vec3 kHigh[6] = vec3[](vec3(4, 0, 6), vec3(4, 3, -4), vec3(-0.95, 3, 0.7),
                                vec3(0.15, 3, -0.9), vec3(0.95, 3, 0.65), vec3(0.75, 1.5, 0.3));
const vec3 kAlbedo[6] = vec3[](vec3(0.35, 0.30, 0.25), vec3(0.5, 0.52, 0.55), vec3(0.7, 0.68, 0.6),
                                  vec3(0.6, 0.3, 0.25), vec3(0.7, 0.68, 0.6), vec3(0));

void main() {
    uint side = gl_VertexIndex / 6, corner = gl_VertexIndex % 6;  // two triangles of a side: 0 1 2, 2 1 3
    uint at = corner < 3 ? corner : corner == 3 ? 2 : corner == 4 ? 1 : 3;
    uint axis = side / 2;
    vec3 unit = vec3(0);
    unit[axis] = float(side % 2);
    unit[(axis + 1) % 3] = float(at % 2);
    unit[(axis + 2) % 3] = float(at / 2);
    world = mix(kLow[gl_InstanceIndex], kHigh[gl_InstanceIndex], unit);
    normal = vec3(0);
    normal[axis] = side % 2 == 1 ? 1.0 : -1.0;
    albedo = kAlbedo[gl_InstanceIndex];
    vec4 p = vec4(world, 1);
    vec3 v = vec3(dot(push.viewRow0, p), dot(push.viewRow1, p), dot(push.viewRow2, p));
    // Reversed, infinite far plane: stored depth = near / z.
    gl_Position = vec4(push.lens.x * v.x + push.lens.z * v.z, push.lens.y * v.y + push.lens.w * v.z, push.near, v.z);
}
