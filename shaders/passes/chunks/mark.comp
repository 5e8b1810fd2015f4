// SPDX-License-Identifier: Apache-2.0
// Marks the groups (kSplatGroup neighbouring splats) that have a splat on a triangle that some view may show. One lane tests the
// triangles of one group, listed in the table of parents of its chunk, and stops at the first hit. No later pass of the frame reads the
// other groups.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
layout(local_size_x = 64) in;  // kChunkGroup

DPL_WORDS(0, CodeBlock, codes);
DPL_FOURS(1, TriangleBlock, triangles);  // TriangleFrame
layout(std430, binding = 2) writeonly buffer VisibilityBlock { uint visibility[]; };
layout(push_constant) uniform PushBlock { CodesPush push; };
#include "shaders/lib/visibility.glsl"
#include "shaders/lib/parent_byte.glsl"
#include "shaders/lib/triangle_frame.glsl"

void main() {
    uint group = gl_GlobalInvocationID.x;
    if (group >= push.groupCount) return;
    uint chunk = (group >> 1u) * kChunkWords, first = DPL_WORD(codes, chunk), begin = (group & 1u) * kSplatGroup, end = min(begin + kSplatGroup, DPL_WORD(codes, chunk + 1u)), live = 0u;
    if (begin < end) {
        uint parents = push.firstParent + DPL_WORD(codes, chunk + kChunkFirstParent), last = parents + dplParentByte(first + end - 1u);
        for (uint at = parents + dplParentByte(first + begin); at <= last && live == 0u; ++at) {
            uint parent = DPL_WORD(codes, at);
            uint wanted = ((parent & kParentFree) != 0u ? 3u * kShowsFree : 0u) | ((parent & kParentGated) != 0u ? 3u * kShowsGated : 0u);
            if ((dplShows(DPL_FOUR(triangles, kTriangleFrameFours * (parent & kParentMask))) & wanted) != 0u) live = 1u;
        }
    }
    group += push.firstGroup;
    visibility[group] = live;
    visibility[dplFirstRange(push.allGroups) + group] = dplRange(push.firstSplat + first + begin, max(end, begin) - begin);
}
