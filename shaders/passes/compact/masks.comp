// SPDX-License-Identifier: Apache-2.0
// Finds which splats of each group are shown by some view, and counts them. One lane reads one group: its splats are neighbours in
// memory.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/visibility.glsl"
layout(local_size_x = 64) in;  // kCompactGroup

DPL_WORDS(0, VisibilityBlock, visibility);
layout(std430, binding = 1) writeonly buffer SurvivorBlock { uint survivors[]; };
layout(push_constant) uniform PushBlock { MaskPush push; };

void main() {
    uint group = gl_GlobalInvocationID.x, sum = 0u;
    if (group >= push.groupCount) return;
    bool lives = DPL_WORD(visibility, group) != 0u;
    uint range = lives ? DPL_WORD(visibility, dplFirstRange(push.groupCount) + group) : 0u, count = dplRangeCount(range);
    uint depth = dplFirstDepth(push.groupCount) + dplRangeFirst(range);
    for (uint word = 0u; word < kMaskWords; ++word) {
        uint mask = 0u;
        for (uint k = 0u; k < 32u && 32u * word + k < count; ++k) mask |= (DPL_WORD(visibility, depth + 32u * word + k) != kUnseenDepth ? 1u : 0u) << k;
        survivors[kMaskWords * group + word] = mask;
        sum += uint(bitCount(mask));
    }
    survivors[dplFirstSum(push.groupCount) + group] = sum;
}
