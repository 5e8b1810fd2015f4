// SPDX-License-Identifier: Apache-2.0
// Built twice, as room.vert.
#version 450
#ifdef MULTIVIEW
#extension GL_EXT_multiview : require
#define VIEW gl_ViewIndex
#else
#define VIEW 0
#endif
layout(push_constant) uniform Push { mat4 clipFromWorld[2]; } push;
layout(location = 0) in vec4 positionAndAlpha;
layout(location = 0) out float alpha;
void main() {
    alpha = positionAndAlpha.w;
    gl_Position = push.clipFromWorld[VIEW] * vec4(positionAndAlpha.xyz, 1);
}
