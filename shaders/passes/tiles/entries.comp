// SPDX-License-Identifier: Apache-2.0
// Writes the record numbers of each tile's splats, nearest first. Afterwards the places hold the end of each segment.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/pairs.glsl"
layout(local_size_x = 32) in;  // kRunGroup

DPL_PAIRS(0, SpanBlock, spans);  // TileSpan
DPL_WORDS(1, SumBlock, sums);
layout(std430, binding = 2) buffer PlaceBlock { uint places[]; };
layout(std430, binding = 3) writeonly buffer EntryBlock { uint entries[]; };
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/segment.glsl"

void main() {
    uint row = gl_GlobalInvocationID.x / kTileSegments, segment = gl_GlobalInvocationID.x % kTileSegments;
    if (row >= push.viewCount * push.rows) return;
    uint first = push.firstTileTable + row * push.columns * kTileSegments + segment, end;
    uint i = dplSegment(row, segment, end);
    if (i >= end) return;
    TileSpan span = dplTileSpan(DPL_PAIR(spans, i));
    uint column = dplFirstColumn(span.columns);
    do {  // one column in each round, as in count.comp
        uint cell = first + column * kTileSegments, place = places[cell];
        entries[place] = span.record;
        places[cell] = place + 1u;
        bool last = column >= dplLastColumn(span.columns);
        i += last ? 1u : 0u;
        span = dplTileSpan(DPL_PAIR(spans, min(i, end - 1u)));
        column = last ? dplFirstColumn(span.columns) : column + 1u;
    } while (i < end);
}
