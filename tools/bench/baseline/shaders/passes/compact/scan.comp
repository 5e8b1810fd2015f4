// SPDX-License-Identifier: Apache-2.0
// Exclusive prefix sum in place by one workgroup; the total goes one past the end. Serves compaction and the sort.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 256) in;  // kScanGroup
#define DPL_SCAN_LANES 256u
#include "tools/bench/baseline/shaders/lib/scan.glsl"

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 1) buffer ValueBlock { uint values[]; };
layout(push_constant) uniform PushBlock { ScanPush push; };

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint count = push.fromSort != 0u ? kSortDigits * counts.sortBlocks : push.count;
    uint share = (count + kScanGroup - 1u) / kScanGroup;
    uint begin = min(lane * share, count), end = min(begin + share, count);
    uint sum = 0u;
    for (uint i = begin; i < end; ++i) sum += values[i];
    uint total;
    uint before = dplExclusiveScan(lane, sum, total);
    for (uint i = begin; i < end; ++i) {
        uint value = values[i];
        values[i] = before;
        before += value;
    }
    if (lane == 0u) values[count] = total;
}
