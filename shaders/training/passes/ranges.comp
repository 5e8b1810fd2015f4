// SPDX-License-Identifier: Apache-2.0
// Where the entries of each tile begin, and the splat of each entry. The buffer of beginnings was filled with zeros.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/shared/frame.h"
layout(local_size_x = 256) in;  // kRun

layout(std430, binding = 1) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 2) readonly buffer SortedBlock { uvec2 sorted[]; };
layout(std430, binding = 3) readonly buffer OwnerBlock { uint owners[]; };
layout(std430, binding = 4) writeonly buffer OffsetBlock { uint offsets[]; };   // tiles + 1
layout(std430, binding = 5) writeonly buffer EntryBlock { uvec2 entries[]; };   // splat, place by splat

void main() {
    uint i = gl_GlobalInvocationID.x, count = counts.visible;
    if (i >= count) return;
    uvec2 own = sorted[i];
    entries[i] = uvec2(owners[own.y], own.y);
    uint before = i == 0u ? 0u : sorted[i - 1u].x + 1u;
    for (uint tile = before; tile <= own.x; ++tile) offsets[tile] = i;
    if (i + 1u == count)
        for (uint tile = own.x + 1u; tile <= frame.tiles; ++tile) offsets[tile] = count;
}
