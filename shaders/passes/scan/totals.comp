// SPDX-License-Identifier: Apache-2.0
// First of three steps of the exclusive prefix sum of a table, row after row: adds up each of the kRowScanGroup shares of a row. Then
// sums.comp scans the shares of all rows, and places.comp the cells.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
layout(local_size_x = 16) in;  // kRowScanGroup

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
DPL_WORDS(1, TableBlock, table);
layout(std430, binding = 2) writeonly buffer SumBlock { uint sums[]; };
layout(push_constant) uniform PushBlock { RowScanPush push; };
#include "shaders/lib/row_share.glsl"

void main() {
    uint end, sum = 0u;
    for (uint i = dplRowShare(end); i < end; ++i) sum += DPL_WORD(table, i);
    sums[push.firstSum + gl_WorkGroupID.x * kRowScanGroup + gl_LocalInvocationIndex] = sum;
}
