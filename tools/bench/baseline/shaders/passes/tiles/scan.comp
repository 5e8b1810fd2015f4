// SPDX-License-Identifier: Apache-2.0
// Exclusive prefix sum of each row of a table, a workgroup a row; the totals go to the row sums.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/tiles.h"
layout(local_size_x = 64) in;  // kTileScanGroup
#define DPL_SCAN_LANES 64u
#include "tools/bench/baseline/shaders/lib/scan.glsl"

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 1) buffer ListBlock { uint lists[]; };
layout(push_constant) uniform PushBlock { TileScanPush push; };

void main() {
    uint lane = gl_LocalInvocationIndex, row = gl_WorkGroupID.x;
    uint count = push.perRow != 0u ? push.perRow : (counts.visible + kTileRun - 1u) / kTileRun, first = push.firstTable + row * count;
    uint share = (count + kTileScanGroup - 1u) / kTileScanGroup;
    uint begin = first + min(lane * share, count), end = first + min((lane + 1u) * share, count), sum = 0u;
    for (uint i = begin; i < end; ++i) sum += lists[i];
    uint total;
    uint before = dplExclusiveScan(lane, sum, total);
    for (uint i = begin; i < end; ++i) {
        uint value = lists[i];
        lists[i] = before;
        before += value;
    }
    if (lane == 0u) lists[push.firstSum + row] = total;
}
