// SPDX-License-Identifier: Apache-2.0
// Turns the number of survivors into the arguments of the sort's dispatches and of the draw, and the depth intervals of the subjects
// into the mapping from depth to key. Intervals that overlap share a range of keys; gaps between intervals take no keys. This is a
// dispatch of its own, because on Metal no barrier inside a kernel reaches other workgroups.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/order.glsl"
layout(local_size_x = 1) in;

layout(std430, binding = 0) readonly buffer SurvivorBlock { uint survivors[]; };
layout(std430, binding = 1) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { ArgsPush push; };
#include "shaders/lib/visibility.glsl"

/** Computes keyStart, keyOffset and keyScale. Each range gets keys in proportion to its length and starts two keys after the range
 *  before. */
void mapDepths() {
    float low[16], high[16];  // kMaxDrawn
    uint order[16];
    uint count = 0u;
    for (uint k = 0u; k < push.drawnCount; ++k) {
        low[k] = dplFromOrderedBits(~counts.depthMinBitsInverted[k]);
        high[k] = dplFromOrderedBits(counts.depthMaxBits[k]);
        counts.keyStart[k] = counts.keyOffset[k] = 0.0;
        if (counts.depthMaxBits[k] == 0u) continue;
        uint at = count;  // insertion sort by the near end
        for (; at > 0u && low[order[at - 1u]] > low[k]; --at) order[at] = order[at - 1u];
        order[at] = k;
        ++count;
    }
    float total = 0.0, reach = 0.0, start = 0.0, before = 0.0;
    uint stretches = 0u;
    for (uint i = 0u; i < count; ++i) {
        uint k = order[i];
        if (i == 0u || low[k] > reach) {
            before = total;
            start = reach = low[k];
            ++stretches;
        }
        if (high[k] > reach) {
            total += high[k] - reach;
            reach = high[k];
        }
        counts.keyStart[k] = start - before;
        counts.keyOffset[k] = 0.5 + 2.0 * float(stretches - 1u);
    }
    counts.keyScale = total > 0.0 ? (float(push.maxDepthKey) - 2.0 * float(max(stretches, 1u) - 1u)) / total : 0.0;
}

void main() {
    uint visible = survivors[dplFirstSum(push.groupCount) + push.groupCount];
    mapDepths();
    counts.visible = visible;
    counts.runs = (visible + kRun - 1u) / kRun;
    counts.runGroupsX = counts.runs;
    counts.runGroupsY = 1u;
    counts.runGroupsZ = 1u;
    counts.drawVertices = 3u * visible;
    counts.drawInstances = push.drawInstances;
    counts.drawFirstVertex = 0u;
    counts.drawFirstInstance = 0u;
}
