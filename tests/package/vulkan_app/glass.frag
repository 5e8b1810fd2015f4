// SPDX-License-Identifier: Apache-2.0
// Tinted glass, premultiplied. As kGlass in room.h.
#version 450
layout(location = 0) out vec4 colour;
void main() {
    colour = vec4(0.05, 0.2, 0.16, 0.5);
}
