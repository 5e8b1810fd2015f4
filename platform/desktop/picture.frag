// SPDX-License-Identifier: Apache-2.0
#version 450
layout(push_constant) uniform Push {
    vec4 corners, part;  // as in picture.vert
    float opacity;
};
layout(binding = 0) uniform sampler2D picture;
layout(location = 0) in vec2 at;
layout(location = 0) out vec4 colour;
void main() {
    colour = texture(picture, at) * vec4(1, 1, 1, opacity);
}
