// SPDX-License-Identifier: Apache-2.0
// Turns the survivor count into the arguments of the sort's dispatches and of the one draw. Its own dispatch: no barrier
// inside a kernel reaches other workgroups on Metal.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
layout(local_size_x = 1) in;

layout(std430, binding = 0) readonly buffer SumBlock { uint blockSums[]; };
layout(std430, binding = 1) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { ArgsPush push; };

void main() {
    uint visible = blockSums[push.blockCount];
    uint blocks = (visible + kSortBlock - 1u) / kSortBlock;
    counts.visible = visible;
    counts.sortBlocks = blocks;
    counts.sortGroupsX = blocks;
    counts.sortGroupsY = 1u;
    counts.sortGroupsZ = 1u;
    counts.drawVertices = 4u;
    counts.drawInstances = visible * push.instancesPerSplat;
    counts.drawFirstVertex = 0u;
    counts.drawFirstInstance = 0u;
}
