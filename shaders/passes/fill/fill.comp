// SPDX-License-Identifier: Apache-2.0
// Fills a buffer with a word. For Metal, whose own fill knows bytes only and would need an encoder of its own between the kernels.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 256) in;  // kFillGroup

layout(std430, binding = 0) writeonly buffer WordBlock { uint words[]; };
layout(push_constant) uniform PushBlock { FillPush push; };

void main() {
    uint first = gl_WorkGroupID.x * kFillWords + gl_LocalInvocationID.x;
    for (uint at = first; at < min((gl_WorkGroupID.x + 1u) * kFillWords, push.count); at += kFillGroup) words[at] = push.value;
}
