// SPDX-License-Identifier: Apache-2.0
// Writes an entry for each tile that a splat touches, nearest splat first and tiles row by row. What does not fit is not written; the host
// sees the number of all, and draws the frame again with longer lists.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) readonly buffer PairBlock { uvec2 pairs[]; };
layout(std430, binding = 2) readonly buffer ScreenBlock { TrainScreen screen[]; };
layout(std430, binding = 3) readonly buffer PlaceBlock { uint places[]; };
layout(std430, binding = 4) writeonly buffer EntryBlock { uvec2 entries[]; };  // SortPair: tile, and place by splat
layout(std430, binding = 5) writeonly buffer OwnerBlock { uint owners[]; };    // splat of each place
layout(std430, binding = 6) writeonly buffer FirstBlock { uint firsts[]; };    // first place of each splat

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= frame.splatCount) return;
    uint splat = pairs[i].y, place = places[i];
    TrainScreen p = screen[splat];
    firsts[splat] = place;
    if (p.tileCount == 0u || place + p.tileCount > frame.entryCapacity) return;
    uvec2 first = uvec2(p.firstTile & 0xFFFFu, p.firstTile >> 16u), last = uvec2(p.lastTile & 0xFFFFu, p.lastTile >> 16u);
    for (uint y = first.y; y <= last.y; ++y)
        for (uint x = first.x; x <= last.x; ++x, ++place) {
            entries[place] = uvec2(y * frame.columns + x, place);
            owners[place] = splat;
        }
}
