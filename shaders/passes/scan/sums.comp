// SPDX-License-Identifier: Apache-2.0
// Exclusive prefix sum in place by one workgroup. The total is written one past the end. For a table it runs over the shares of its
// rows (totals.comp).
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 256) in;  // kScanGroup
#define DPL_SCAN_LANES 256u
#include "shaders/lib/scan.glsl"

layout(std430, binding = 0) buffer ValueBlock { uint values[]; };
layout(push_constant) uniform PushBlock { ScanPush push; };

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint count = push.count;
    uint share = (count + kScanGroup - 1u) / kScanGroup;
    uint begin = push.first + min(lane * share, count), end = push.first + min((lane + 1u) * share, count);
    uint sum = 0u;
    for (uint i = begin; i < end; ++i) sum += values[i];
    uint total;
    uint before = dplExclusiveScan(lane, sum, total);
    for (uint i = begin; i < end; ++i) {
        uint value = values[i];
        values[i] = before;
        before += value;
    }
    if (lane == 0u) values[push.first + count] = total;
}
