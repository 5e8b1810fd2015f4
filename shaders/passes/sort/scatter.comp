// SPDX-License-Identifier: Apache-2.0
// Moves each pair to its place for one digit. Equal digits keep their order (stable). Key and splat are two words until only one digit is
// left.
// DPL_PACK: writes that digit into the upper bits of the splat's word. DPL_PACKED: the round after, which leaves splat numbers alone.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/pairs.glsl"
layout(local_size_x = 32) in;  // kRunGroup

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
#ifdef DPL_PACKED
DPL_WORDS(1, PairBlock, pairs);
#else
DPL_PAIRS(1, PairBlock, pairs);  // SortPair
#endif
DPL_WORDS(2, PlaceBlock, places);
#if defined(DPL_PACK) || defined(DPL_PACKED)
layout(std430, binding = 3) writeonly buffer SortedBlock { uint sorted[]; };
#else
layout(std430, binding = 3) writeonly buffer SortedBlock { SortPair sorted[]; };
#endif
layout(push_constant) uniform PushBlock { SortPush push; };

#define DPL_LISTS kSortDigits
#include "shaders/lib/ranks.glsl"

void main() {
    uint run = gl_WorkGroupID.x, end = min((run + 1u) * kRun, counts.visible);
    for (uint digit = gl_LocalInvocationIndex; digit < kSortDigits; digit += kRunGroup)
        dplStartList(digit, DPL_WORD(places, digit * counts.runs + run));
    barrier();
    for (uint first = run * kRun; first < end; first += kRunGroup) {
        uint i = first + gl_LocalInvocationIndex;
        bool has = i < end;
#ifdef DPL_PACKED
        uint packed = has ? DPL_WORD(pairs, i) : 0u, digit = packed >> kSortIndexBits, splat = packed & ((1u << kSortIndexBits) - 1u);
#else
        SortPair pair = dplSortPair(has ? DPL_PAIR(pairs, i) : uvec2(0u));
        uint digit = (pair.key >> push.shift) & (kSortDigits - 1u);
#endif
        if (has) dplJoin(digit);
        barrier();
        if (has) {
            uint place = dplPlaceIn(digit);
#ifdef DPL_PACK
            sorted[place] = ((pair.key >> (push.shift + kSortDigitBits)) << kSortIndexBits) | pair.splat;
#elif defined(DPL_PACKED)
            sorted[place] = splat;
#else
            sorted[place] = pair;
#endif
        }
        barrier();
        if (has) dplLeave(digit);
    }
}
