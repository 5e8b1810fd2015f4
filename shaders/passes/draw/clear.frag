// SPDX-License-Identifier: Apache-2.0
// Transparent black, no depth, in place of what was there.
#version 450
layout(location = 0) out vec4 colour;
#ifdef DPL_DEPTH
layout(location = 1) out vec4 depthSums;
#endif

void main() {
    colour = vec4(0.0);
#ifdef DPL_DEPTH
    depthSums = vec4(0.0);
#endif
}
