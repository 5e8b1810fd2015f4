// SPDX-License-Identifier: Apache-2.0
// Moves each pair to its place for one digit. Lanes own runs of neighbouring pairs and the lane counters are summed
// digit-major, so equal digits keep their order (stable) whatever the subgroup width.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kSortGroup
#define DPL_SCAN_LANES 128u
#include "tools/bench/baseline/shaders/lib/scan.glsl"

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 1) readonly buffer PairBlock { uvec2 pairs[]; };
layout(std430, binding = 2) readonly buffer HistogramBlock { uint offsets[]; };
layout(std430, binding = 3) writeonly buffer SortedBlock { uvec2 sorted[]; };
layout(push_constant) uniform PushBlock { SortPush push; };
shared uint laneCount[2048];  // kSortDigits * kSortGroup: [digit][lane]
shared uint digitStart[16];

void main() {
    uint lane = gl_LocalInvocationIndex, block = gl_WorkGroupID.x;
    uint begin = min(block * kSortBlock + lane * kSortItemsPerLane, counts.visible);
    uint end = min(begin + kSortItemsPerLane, counts.visible);
    for (uint digit = 0u; digit < kSortDigits; ++digit) laneCount[digit * kSortGroup + lane] = 0u;
    for (uint i = begin; i < end; ++i) laneCount[((pairs[i].x >> push.shift) & (kSortDigits - 1u)) * kSortGroup + lane]++;
    barrier();
    // Prefix sum over the whole table: each lane takes 16 neighbouring counters.
    uint row = lane * kSortDigits, sum = 0u;
    for (uint k = 0u; k < kSortDigits; ++k) sum += laneCount[row + k];
    uint total;
    uint before = dplExclusiveScan(lane, sum, total);
    for (uint k = 0u; k < kSortDigits; ++k) {
        uint value = laneCount[row + k];
        laneCount[row + k] = before;
        before += value;
    }
    barrier();
    if (lane < kSortDigits) digitStart[lane] = offsets[lane * counts.sortBlocks + block] - laneCount[lane * kSortGroup];
    barrier();
    for (uint i = begin; i < end; ++i) {
        uvec2 pair = pairs[i];
        uint digit = (pair.x >> push.shift) & (kSortDigits - 1u);
        sorted[digitStart[digit] + laneCount[digit * kSortGroup + lane]++] = pair;
    }
}
