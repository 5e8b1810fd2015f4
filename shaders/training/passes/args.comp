// SPDX-License-Identifier: Apache-2.0
// Turns the number of entries into the counts that sort and ranges read. Lists that are too short hold nothing.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/shared/frame.h"
layout(local_size_x = 1) in;

layout(std430, binding = 1) readonly buffer SumBlock { uint sums[]; };
layout(std430, binding = 2) buffer CountsBlock { FrameCounts counts; };

void main() {
    uint rows = (frame.splatCount + kTrainScanCells - 1u) / kTrainScanCells, wanted = sums[rows * kRowScanGroup];
    uint held = wanted <= frame.entryCapacity ? wanted : 0u;
    counts.tileEntries = wanted;
    counts.visible = held;
    counts.runs = (held + kRun - 1u) / kRun;
    counts.runGroupsX = counts.runs;
    counts.runGroupsY = 1u;
    counts.runGroupsZ = 1u;
}
