// SPDX-License-Identifier: Apache-2.0
// Entries of each tile: [row][column][segment]. kTileSegments lanes share the spans of a row in equal, ordered parts.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/tiles.h"
layout(local_size_x = 32) in;  // kTileListGroup

layout(std430, binding = 0) buffer ListBlock { uint lists[]; };
layout(push_constant) uniform PushBlock { TilePush push; };

void main() {
    uint row = gl_GlobalInvocationID.x / kTileSegments, segment = gl_GlobalInvocationID.x % kTileSegments;
    if (row >= push.rows) return;
    uint table = push.firstTileTable + row * push.columns * kTileSegments + segment;
    for (uint column = 0u; column < push.columns; ++column) lists[table + column * kTileSegments] = 0u;
    uint first = lists[push.firstSpanSum + row], share = (lists[push.firstSpanSum + row + 1u] - first + kTileSegments - 1u) / kTileSegments;
    uint begin = first + segment * share, end = min(begin + share, lists[push.firstSpanSum + row + 1u]);
    for (uint i = begin; i < end; ++i) {
        uint columns = lists[push.firstSpan + 2u * i + 1u];
        for (uint column = columns & 0xFFFFu; column <= columns >> 16u; ++column) lists[table + column * kTileSegments]++;
    }
}
