// Exclusive prefix sum of each row of a table, a workgroup a row; the totals go to the row sums.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 16) in;  // kRowScanGroup
#define DPL_SCAN_LANES 16u
#include "shaders/lib/scan.glsl"

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 1) buffer TableBlock { uint table[]; };
layout(push_constant) uniform PushBlock { RowScanPush push; };

void main() {
    uint lane = gl_LocalInvocationIndex, row = gl_WorkGroupID.x;
    uint count = push.perRow != 0u ? push.perRow : counts.runs, first = push.firstTable + row * count;
    uint share = (count + kRowScanGroup - 1u) / kRowScanGroup;
    uint begin = first + min(lane * share, count), end = first + min((lane + 1u) * share, count), sum = 0u;
    for (uint i = begin; i < end; ++i) sum += table[i];
    uint total;
    uint before = dplExclusiveScan(lane, sum, total);
    for (uint i = begin; i < end; ++i) {
        uint value = table[i];
        table[i] = before;
        before += value;
    }
    if (lane == 0u) table[push.firstSum + row] = total;
}
