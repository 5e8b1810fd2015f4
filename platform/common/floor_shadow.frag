// SPDX-License-Identifier: Apache-2.0
#version 450
layout(location = 0) in float alpha;
layout(location = 0) out vec4 colour;
void main() {
    colour = vec4(0, 0, 0, alpha);
}
