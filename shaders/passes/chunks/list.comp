// SPDX-License-Identifier: Apache-2.0
// Lists the live groups of one avatar in order and writes the arguments of the dispatches over them. One workgroup is enough.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 256) in;  // kScanGroup
#define DPL_SCAN_LANES 256u
#include "shaders/lib/scan.glsl"

layout(std430, binding = 0) buffer VisibilityBlock { uint visibility[]; };
layout(std430, binding = 1) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { ChunkPush push; };
#include "shaders/lib/visibility.glsl"

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint share = (push.groupCount + kScanGroup - 1u) / kScanGroup;
    uint begin = min(lane * share, push.groupCount), end = min(begin + share, push.groupCount), count = 0u;
    for (uint i = begin; i < end; ++i) count += visibility[push.firstGroup + i];
    uint total;
    uint slot = dplFirstLive(push.allGroups) + push.firstGroup + dplExclusiveScan(lane, count, total);
    for (uint i = begin; i < end; ++i) {
        if (visibility[push.firstGroup + i] == 0u) continue;
        visibility[slot] = i;
        ++slot;
    }
    if (lane == 0u) {
        counts.chunkGroupsX = total;
        counts.chunkGroupsY = 1u;
        counts.chunkGroupsZ = 1u;
        counts.chunksProjected += total;
    }
}
