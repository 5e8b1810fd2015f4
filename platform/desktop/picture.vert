// SPDX-License-Identifier: Apache-2.0
// The two triangles of a picture that lies flat in the frame.
#version 450
layout(push_constant) uniform Push {
    vec4 corners;  // left, top, right, bottom in clip space
    vec4 part;     // the same of the picture, 0 to 1
    float opacity;
};
layout(location = 0) out vec2 at;
void main() {
    bvec2 far = bvec2(gl_VertexIndex == 1 || gl_VertexIndex == 3 || gl_VertexIndex == 5, gl_VertexIndex == 2 || gl_VertexIndex >= 4);
    gl_Position = vec4(mix(corners.xy, corners.zw, far), 0, 1);
    at = mix(part.xy, part.zw, far);
}
