// SPDX-License-Identifier: Apache-2.0
// Digit histogram of each block of kSortBlock keys, digit-major so that one prefix sum gives every block its places.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kSortGroup

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 1) readonly buffer PairBlock { uvec2 pairs[]; };
layout(std430, binding = 2) writeonly buffer HistogramBlock { uint histogram[]; };
layout(push_constant) uniform PushBlock { SortPush push; };
shared uint digitCount[16];  // kSortDigits

void main() {
    uint lane = gl_LocalInvocationIndex, block = gl_WorkGroupID.x;
    if (lane < kSortDigits) digitCount[lane] = 0u;
    barrier();
    uint end = min((block + 1u) * kSortBlock, counts.visible);
    for (uint i = block * kSortBlock + lane; i < end; i += kSortGroup)
        atomicAdd(digitCount[(pairs[i].x >> push.shift) & (kSortDigits - 1u)], 1u);
    barrier();
    if (lane < kSortDigits) histogram[lane * counts.sortBlocks + block] = digitCount[lane];
}
