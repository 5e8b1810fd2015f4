// SPDX-License-Identifier: Apache-2.0
// A room of boxes: floor, back wall and columns. Each instance is a box, each three vertices a triangle. MULTIVIEW: both eyes at once.
#version 450
#ifdef MULTIVIEW
#extension GL_EXT_multiview : require
#define VIEW gl_ViewIndex
#else
#define VIEW 0
#endif
struct View {
    vec4 row0, row1, row2;  // [R | t], x right, y down, z forward
    vec4 lens;              // 2 fx / width, 2 fy / height, 2 cx / width - 1, 2 cy / height - 1
};
layout(push_constant) uniform Push {
    View views[2];
} push;
layout(constant_id = 0) const float kNearM = 0.1;
layout(location = 0) out vec3 world;
layout(location = 1) flat out vec3 normal;
layout(location = 2) flat out vec3 albedo;

const vec3 kLow[6] = vec3[](vec3(-4, -0.1, -5), vec3(-4, 0, -5.1), vec3(0.10, 0, -1.45), vec3(-1.1, 0, -2.9), vec3(0.85, 0, -3.4), vec3(-0.75, 0, -1.3));
const vec3 kHigh[6] = vec3[](vec3(4, 0, 3), vec3(4, 3, -5), vec3(0.22, 1.1, -1.33), vec3(-0.9, 3, -2.7), vec3(1.05, 3, -3.2), vec3(-0.6, 0.5, -1.15));
const vec3 kAlbedo[6] = vec3[](vec3(0.34, 0.31, 0.28), vec3(0.5, 0.52, 0.56), vec3(0.65, 0.3, 0.24), vec3(0.7, 0.68, 0.6), vec3(0.7, 0.68, 0.6), vec3(0.25, 0.42, 0.5));

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
    View view = push.views[VIEW];
    vec4 p = vec4(world, 1);
    vec3 v = vec3(dot(view.row0, p), dot(view.row1, p), dot(view.row2, p));
    // Reversed depth with an infinite far plane: near / z.
    gl_Position = vec4(view.lens.x * v.x + view.lens.z * v.z, view.lens.y * v.y + view.lens.w * v.z, kNearM, v.z);
}
