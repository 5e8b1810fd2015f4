// SPDX-License-Identifier: Apache-2.0
// The frame of a training step, and names for what its buffers hold.
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/shared/train.h"
#include "shaders/lib/formulas.glsl"
layout(std140, binding = 0) uniform FrameBlock { TrainFrame frame; };

vec3 viewTurned(vec3 world) {
    return vec3(dot(frame.viewFromWorldRow0.xyz, world), dot(frame.viewFromWorldRow1.xyz, world), dot(frame.viewFromWorldRow2.xyz, world));
}
vec3 viewOf(vec3 world) {
    return viewTurned(world) + vec3(frame.viewFromWorldRow0.w, frame.viewFromWorldRow1.w, frame.viewFromWorldRow2.w);
}
