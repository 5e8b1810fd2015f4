// SPDX-License-Identifier: Apache-2.0
// Writes the records of each tile's splats, near first. Afterwards the table says where the part of each segment ends.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/tiles.h"
layout(local_size_x = 32) in;  // kTileListGroup

layout(std430, binding = 0) buffer ListBlock { uint lists[]; };
layout(std430, binding = 1) writeonly buffer EntryBlock { uint entries[]; };
layout(push_constant) uniform PushBlock { TilePush push; };

void main() {
    uint row = gl_GlobalInvocationID.x / kTileSegments, segment = gl_GlobalInvocationID.x % kTileSegments;
    if (row >= push.rows) return;
    uint table = push.firstTileTable + row * push.columns * kTileSegments + segment, place = lists[push.firstEntrySum + row];
    uint first = lists[push.firstSpanSum + row], share = (lists[push.firstSpanSum + row + 1u] - first + kTileSegments - 1u) / kTileSegments;
    uint begin = first + segment * share, end = min(begin + share, lists[push.firstSpanSum + row + 1u]);
    for (uint i = begin; i < end; ++i) {
        uint slot = lists[push.firstSpan + 2u * i], columns = lists[push.firstSpan + 2u * i + 1u];
        for (uint column = columns & 0xFFFFu; column <= columns >> 16u; ++column) {
            uint cursor = table + column * kTileSegments;
            entries[place + lists[cursor]] = slot;
            lists[cursor]++;
        }
    }
}
