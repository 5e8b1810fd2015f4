// Moves each pair to its place for one digit. A lane moves a run of neighbours in order, so equal digits keep theirs (stable).
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
layout(local_size_x = 32) in;  // kRunGroup

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
DPL_PAIRS(1, PairBlock, pairs);
layout(std430, binding = 2) buffer PlaceBlock { uint places[]; };
layout(std430, binding = 3) writeonly buffer SortedBlock { uvec2 sorted[]; };
layout(push_constant) uniform PushBlock { SortPush push; };

void main() {
    uint run = gl_GlobalInvocationID.x, runs = counts.runs;
    if (run >= runs) return;
    uint end = min((run + 1u) * kRun, counts.visible);
    for (uint i = run * kRun; i < end; ++i) {
        uvec2 pair = DPL_PAIR(pairs, i);
        uint cell = ((pair.x >> push.shift) & (kSortDigits - 1u)) * runs + run, place = places[cell];
        sorted[place] = pair;
        places[cell] = place + 1u;
    }
}
