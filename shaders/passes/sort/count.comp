// SPDX-License-Identifier: Apache-2.0
// Counts each digit in each run of keys: [digit][run]. Prefix sums over this table give every run its places.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/pairs.glsl"
layout(local_size_x = 32) in;  // kRunGroup

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
#ifdef DPL_PACKED  // the last digit lies above the number of the splat
DPL_WORDS(1, PairBlock, pairs);
#else
DPL_PAIRS(1, PairBlock, pairs);  // SortPair
#endif
layout(std430, binding = 2) writeonly buffer TableBlock { uint table[]; };
layout(push_constant) uniform PushBlock { SortPush push; };

#define DPL_LISTS kSortDigits
#include "shaders/lib/tally.glsl"

void main() {
    uint run = gl_WorkGroupID.x, end = min((run + 1u) * kRun, counts.visible);
    dplClearTally(kSortDigits);
    for (uint i = run * kRun + gl_LocalInvocationIndex; i < end; i += kRunGroup) {
#ifdef DPL_PACKED
        uint digit = DPL_WORD(pairs, i) >> kSortIndexBits;
#else
        uint digit = (dplSortPair(DPL_PAIR(pairs, i)).key >> push.shift) & (kSortDigits - 1u);
#endif
        atomicAdd(dplTally[digit], 1u);
    }
    barrier();
    for (uint digit = gl_LocalInvocationIndex; digit < kSortDigits; digit += kRunGroup) table[digit * counts.runs + run] = dplTally[digit];
}
