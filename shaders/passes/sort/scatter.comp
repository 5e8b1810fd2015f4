// SPDX-License-Identifier: Apache-2.0
// Moves each pair to its place for one digit. One lane moves one run in order, so equal digits keep their order (stable). Key and splat
// are two words until only one digit is left.
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
layout(std430, binding = 2) buffer PlaceBlock { uint places[]; };
#if defined(DPL_PACK) || defined(DPL_PACKED)
layout(std430, binding = 3) writeonly buffer SortedBlock { uint sorted[]; };
#else
layout(std430, binding = 3) writeonly buffer SortedBlock { SortPair sorted[]; };
#endif
layout(push_constant) uniform PushBlock { SortPush push; };

void main() {
    uint run = gl_GlobalInvocationID.x, runs = counts.runs;
    if (run >= runs) return;
    uint end = min((run + 1u) * kRun, counts.visible);
    for (uint i = run * kRun; i < end; ++i) {
#ifdef DPL_PACKED
        uint packed = DPL_WORD(pairs, i), digit = packed >> kSortIndexBits, splat = packed & ((1u << kSortIndexBits) - 1u);
#else
        SortPair pair = dplSortPair(DPL_PAIR(pairs, i));
        uint digit = (pair.key >> push.shift) & (kSortDigits - 1u);
#endif
        uint cell = digit * runs + run, place = places[cell];
#ifdef DPL_PACK
        sorted[place] = ((pair.key >> (push.shift + kSortDigitBits)) << kSortIndexBits) | pair.splat;
#elif defined(DPL_PACKED)
        sorted[place] = splat;
#else
        sorted[place] = pair;
#endif
        places[cell] = place + 1u;
    }
}
