// SPDX-License-Identifier: Apache-2.0
// Linear values of all splats, from rows that the host has written: the device computes them itself, so that a training that goes on from a
// checkpoint draws what one that was not interrupted draws.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) buffer SplatBlock { TrainSplat splats[]; };
layout(std430, binding = 2) writeonly buffer ShBlock { float sh[]; };
layout(std430, binding = 3) buffer RowBlock { float rows[]; };
layout(std430, binding = 4) readonly buffer ConstantBlock { TrainTriangleConstants constants[]; };
#include "shaders/training/lib/activate.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < frame.splatCount) activateSplat(i, constants[splats[i].triangle].floorM);
}
