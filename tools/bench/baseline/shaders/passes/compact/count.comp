// SPDX-License-Identifier: Apache-2.0
// Survivors in each block of kCompactBlock splats.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 256) in;  // kScanGroup

layout(std430, binding = 0) readonly buffer DepthBlock { uint sortDepth[]; };
layout(std430, binding = 1) writeonly buffer SumBlock { uint blockSums[]; };
layout(push_constant) uniform PushBlock { CompactPush push; };
shared uint groupCount;

void main() {
    uint lane = gl_LocalInvocationIndex;
    if (lane == 0u) groupCount = 0u;
    barrier();
    uint first = gl_WorkGroupID.x * kCompactBlock + lane * kCompactItemsPerLane, count = 0u;
    for (uint i = first; i < min(first + kCompactItemsPerLane, push.splatCount); ++i) count += sortDepth[i] != kInvisibleKey ? 1u : 0u;
    if (count != 0u) atomicAdd(groupCount, count);
    barrier();
    if (lane == 0u) blockSums[gl_WorkGroupID.x] = groupCount;
}
