// Which chunks (kSplatGroup neighbouring splats) have a splat whose triangle some view may show. The splats of the others are invisible: nothing else
// of them is read in this frame.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std430, binding = 0) readonly buffer SplatBlock { SplatRecord splats[]; };
layout(std430, binding = 1) readonly buffer TriangleBlock { TriangleFrame triangles[]; };
layout(std430, binding = 2) writeonly buffer VisibilityBlock { uint visibility[]; };
layout(push_constant) uniform PushBlock { SplatPush push; };
shared uint live;

void main() {
    uint lane = gl_LocalInvocationIndex, index = gl_WorkGroupID.x * kSplatGroup + lane;
    if (lane == 0u) live = 0u;
    barrier();
    if (index < push.splatCount) {
        uint splat = splats[index].triangleAndFlags;
        uint wanted = ((splat >> kFlagShift) & kGateFlag) != 0u ? 3u * kShowsGated : 3u * kShowsFree;
        if ((uint(triangles[splat & kTriangleMask].v0.w) & wanted) != 0u) atomicMax(live, 1u);
    }
    barrier();
    if (lane == 0u) visibility[gl_WorkGroupID.x] = live;
    if (live == 0u && index < push.splatCount) visibility[2u * push.chunkCount + index] = kInvisibleKey;
}
