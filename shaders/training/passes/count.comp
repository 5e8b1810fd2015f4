// SPDX-License-Identifier: Apache-2.0
// Counts the tiles that each splat touches, nearest splat first.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) readonly buffer PairBlock { uvec2 pairs[]; };
layout(std430, binding = 2) readonly buffer ScreenBlock { TrainScreen screen[]; };
layout(std430, binding = 3) writeonly buffer CellBlock { uint cells[]; };  // a whole number of rows of kTrainScanCells

void main() {
    uint i = gl_GlobalInvocationID.x, cells_ = (frame.splatCount + kTrainScanCells - 1u) / kTrainScanCells * kTrainScanCells;
    if (i < cells_) cells[i] = i < frame.splatCount ? screen[pairs[i].y].tileCount : 0u;
}
