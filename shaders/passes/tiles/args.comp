// SPDX-License-Identifier: Apache-2.0
// Compares the size that the lists need with their capacity: once after the spans are counted, and once (DPL_ENTRIES) after the entries
// are counted. If a list is too small, the remaining passes that need lists get no work, and search.comp fills the frame.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 1) in;

layout(std430, binding = 0) readonly buffer SumBlock { uint sums[]; };
layout(std430, binding = 1) buffer CountsBlock { FrameCounts counts; };
#ifndef DPL_ENTRIES
layout(std430, binding = 2) writeonly buffer PlaceBlock { uint places[]; };
#endif
layout(push_constant) uniform PushBlock { TilePush push; };

void main() {
    uint rows = push.viewCount * push.rows, rowGroups = rows * kTileSegments;
#ifdef DPL_ENTRIES
    uint entries = counts.tilesOverflowed == 0u ? sums[push.firstEntrySum + rows * kRowScanGroup] : 0u;
    bool fits = counts.tilesOverflowed == 0u && entries <= push.entryCapacity;
    counts.tileEntries = entries;
    counts.tilesOverflowed = fits ? 0u : 1u;
    counts.entryGroupsX = fits ? rowGroups : 0u;
    counts.entryGroupsY = 1u;
    counts.entryGroupsZ = 1u;
    counts.fillGroupsX = fits ? push.fillGroups : 0u;
    counts.fillGroupsY = 1u;
    counts.fillGroupsZ = 1u;
    counts.searchGroupsX = fits ? 0u : push.fillGroups;
    counts.searchGroupsY = 1u;
    counts.searchGroupsZ = 1u;
#else
    uint spans = sums[push.firstSpanSum + rows * kRowScanGroup];
    bool fits = spans <= push.spanCapacity;
    places[0] = counts.visible;  // spans.comp and search.comp read the counts here, because all their four bindings are taken
    places[1] = counts.runs;
    places[2] = spans;
    counts.tileSpans = spans;
    counts.tilesOverflowed = fits ? 0u : 1u;
    counts.rowGroupsX = fits ? rowGroups : 0u;
    counts.rowGroupsY = 1u;
    counts.rowGroupsZ = 1u;
#endif
}
