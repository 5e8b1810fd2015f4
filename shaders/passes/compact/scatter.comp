// SPDX-License-Identifier: Apache-2.0
// Writes (depth key, splat) of each survivor in splat order, so that equal keys keep their order from frame to frame. One lane handles
// 32 splats of a group.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
layout(local_size_x = 64) in;  // kCompactGroup

DPL_WORDS(0, VisibilityBlock, visibility);
DPL_WORDS(1, SurvivorBlock, survivors);
layout(std430, binding = 2) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 3) writeonly buffer PairBlock { SortPair pairs[]; };
layout(push_constant) uniform PushBlock { CompactPush push; };
#include "shaders/lib/visibility.glsl"

void main() {
    uint group = gl_GlobalInvocationID.x / kMaskWords, word = gl_GlobalInvocationID.x % kMaskWords;
    if (group >= push.groupCount) return;
    uint masks = kMaskWords * group, left = DPL_WORD(survivors, masks + word);
    if (left == 0u) return;
    uint slot = DPL_WORD(survivors, dplFirstSum(push.groupCount) + group), first = dplRangeFirst(DPL_WORD(visibility, dplFirstRange(push.groupCount) + group)) + 32u * word;
    for (uint k = 0u; k < word; ++k) slot += uint(bitCount(DPL_WORD(survivors, masks + k)));
    uint drawn = 0u;
    for (uint k = 0u; k + 1u < push.drawnCount; ++k) drawn += group >= push.endGroup[k] ? 1u : 0u;
    float start = counts.keyStart[drawn], offset = counts.keyOffset[drawn], scale = counts.keyScale, most = float(push.maxDepthKey);
    while (left != 0u) {
        uint splat = first + uint(findLSB(left)), bits = DPL_WORD(visibility, dplFirstDepth(push.groupCount) + splat);
        left &= left - 1u;
        // with 24 bits, adding the half may round up to 2²⁴
        float level = clamp((uintBitsToFloat(bits) - start) * scale + offset, 0.0, most);
        pairs[slot] = SortPair(uint(level), splat);
        ++slot;
    }
}
