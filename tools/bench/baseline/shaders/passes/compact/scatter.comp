// SPDX-License-Identifier: Apache-2.0
// Writes (float depth key, splat) of each survivor in splat order, so equal keys never change places between frames.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
#include "tools/bench/baseline/shaders/lib/order.glsl"
layout(local_size_x = 256) in;  // kScanGroup
#define DPL_SCAN_LANES 256u
#include "tools/bench/baseline/shaders/lib/scan.glsl"

layout(std430, binding = 0) readonly buffer DepthBlock { uint sortDepth[]; };
layout(std430, binding = 1) readonly buffer SumBlock { uint blockSums[]; };
layout(std430, binding = 2) writeonly buffer PairBlock { uvec2 pairs[]; };
layout(push_constant) uniform PushBlock { CompactPush push; };

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint first = gl_WorkGroupID.x * kCompactBlock + lane * kCompactItemsPerLane;
    uint end = min(first + kCompactItemsPerLane, push.splatCount), count = 0u;
    for (uint i = first; i < end; ++i) count += sortDepth[i] != kInvisibleKey ? 1u : 0u;
    uint total;
    uint slot = blockSums[gl_WorkGroupID.x] + dplExclusiveScan(lane, count, total);
    for (uint i = first; i < end; ++i) {
        uint bits = sortDepth[i];
        if (bits == kInvisibleKey) continue;
        pairs[slot] = uvec2(dplOrderedBits(uintBitsToFloat(bits)), i);
        ++slot;
    }
}
