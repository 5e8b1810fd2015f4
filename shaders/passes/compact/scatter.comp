// Writes (depth key, splat) of each survivor in splat order, so equal keys never change places between frames.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/order.glsl"
layout(local_size_x = 256) in;  // kScanGroup
#define DPL_SCAN_LANES 256u
#include "shaders/lib/scan.glsl"

layout(std430, binding = 0) readonly buffer VisibilityBlock { uint visibility[]; };
layout(std430, binding = 1) readonly buffer SumBlock { uint blockSums[]; };
layout(std430, binding = 2) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 3) writeonly buffer PairBlock { uvec2 pairs[]; };
layout(push_constant) uniform PushBlock { CompactPush push; };

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint first = gl_WorkGroupID.x * kCompactBlock + lane * kCompactItemsPerLane;
    uint end = min(first + kCompactItemsPerLane, push.splatCount), count = 0u;
    for (uint i = first; i < end; ++i) count += visibility[push.firstDepth + i] != kInvisibleKey ? 1u : 0u;
    uint total;
    uint slot = blockSums[gl_WorkGroupID.x] + dplExclusiveScan(lane, count, total);
    float nearest = dplFromOrderedBits(~counts.depthMinBitsInverted), farthest = dplFromOrderedBits(counts.depthMaxBits);
    float most = float(push.maxDepthKey), scale = farthest > nearest ? most / (farthest - nearest) : 0.0;
    for (uint i = first; i < end; ++i) {
        uint bits = visibility[push.firstDepth + i];
        if (bits == kInvisibleKey) continue;
        float level = clamp((uintBitsToFloat(bits) - nearest) * scale + 0.5, 0.0, most);  // at 24 bits adding the half may round up to 2²⁴
        pairs[slot] = uvec2(push.maxDepthKey == kFloatDepthKeys ? dplOrderedBits(uintBitsToFloat(bits)) : uint(level), i);
        ++slot;
    }
}
