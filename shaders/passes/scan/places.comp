// SPDX-License-Identifier: Apache-2.0
// Last of three steps of the prefix sum of a table (totals.comp): writes where each cell begins, from where its share begins.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
layout(local_size_x = 16) in;  // kRowScanGroup

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
DPL_WORDS(1, TableBlock, table);
DPL_WORDS(2, SumBlock, sums);
layout(std430, binding = 3) writeonly buffer PlaceBlock { uint places[]; };
layout(push_constant) uniform PushBlock { RowScanPush push; };
#include "shaders/lib/row_share.glsl"

void main() {
    uint end, before = DPL_WORD(sums, push.firstSum + gl_WorkGroupID.x * kRowScanGroup + gl_LocalInvocationIndex);
    for (uint i = dplRowShare(end); i < end; ++i) {
        places[i] = before;
        before += DPL_WORD(table, i);
    }
}
