// Turns the survivor count into the arguments of the sort's dispatches and of the one draw. Its own dispatch: no barrier
// inside a kernel reaches other workgroups on Metal.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 1) in;

layout(std430, binding = 0) readonly buffer VisibilityBlock { uint visibility[]; };
layout(std430, binding = 1) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { ArgsPush push; };
#include "shaders/lib/visibility.glsl"

void main() {
    uint visible = visibility[dplFirstSum(push.groupCount) + push.groupCount];
    counts.visible = visible;
    counts.runs = (visible + kRun - 1u) / kRun;
    counts.runGroupsX = (counts.runs + kRunGroup - 1u) / kRunGroup;
    counts.runGroupsY = 1u;
    counts.runGroupsZ = 1u;
    counts.drawVertices = 4u;
    counts.drawInstances = visible * push.instancesPerSplat;
    counts.drawFirstVertex = 0u;
    counts.drawFirstInstance = 0u;
}
