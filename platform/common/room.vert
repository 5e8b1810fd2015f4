// SPDX-License-Identifier: Apache-2.0
// Built twice: for one view, and with MULTIVIEW for the views of a multiview pass.
#version 450
#ifdef MULTIVIEW
#extension GL_EXT_multiview : require
#define VIEW gl_ViewIndex
#else
#define VIEW 0
#endif
layout(push_constant) uniform Push { mat4 clipFromWorld[2]; } push;
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 inNormal;
layout(location = 2) in vec2 about;  // surface, open
layout(location = 0) out vec3 world;
layout(location = 1) out vec3 normal;
layout(location = 2) out float open;
layout(location = 3) flat out int surface;
void main() {
    world = position;
    normal = inNormal;
    open = about.y;
    surface = int(about.x + 0.5);
    gl_Position = push.clipFromWorld[VIEW] * vec4(position, 1);
}
