// SPDX-License-Identifier: Apache-2.0
// Compares what the lists would hold with what they can: once when the spans are counted, once (DPL_ENTRIES) when the entries are. A list that is
// too small leaves the rest of the tile passes without work, and nothing is drawn.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/tiles.h"
layout(local_size_x = 1) in;

layout(std430, binding = 0) readonly buffer ListBlock { uint lists[]; };
layout(std430, binding = 1) buffer TileCountsBlock { TileCounts tiles; };
#ifndef DPL_ENTRIES
layout(std430, binding = 2) readonly buffer CountsBlock { FrameCounts counts; };
#endif
layout(push_constant) uniform PushBlock { TilePush push; };

void main() {
    uint rows = push.rows, rowGroups = (rows * kTileSegments + kTileListGroup - 1u) / kTileListGroup;
#ifdef DPL_ENTRIES
    uint entries = tiles.overflowed == 0u ? lists[push.firstEntrySum + rows] : 0u;
    bool fits = tiles.overflowed == 0u && entries <= push.entryCapacity;
    tiles.entries = entries;
    tiles.overflowed = fits ? 0u : 1u;
    tiles.entryGroupsX = fits ? rowGroups : 0u;
    tiles.entryGroupsY = 1u;
    tiles.entryGroupsZ = 1u;
    tiles.fillGroupsX = fits ? push.fillGroups : 0u;
    tiles.fillGroupsY = 1u;
    tiles.fillGroupsZ = 1u;
#else
    uint spans = lists[push.firstSpanSum + rows];
    bool fits = spans <= push.spanCapacity;
    tiles.spans = spans;
    tiles.overflowed = fits ? 0u : 1u;
    tiles.spanGroupsX = fits ? ((counts.visible + kTileRun - 1u) / kTileRun + kTileListGroup - 1u) / kTileListGroup : 0u;
    tiles.spanGroupsY = 1u;
    tiles.spanGroupsZ = 1u;
    tiles.rowGroupsX = fits ? rowGroups : 0u;
    tiles.rowGroupsY = 1u;
    tiles.rowGroupsZ = 1u;
#endif
}
