// Phase 1: which half-chunks (kSplatGroup neighbouring splats) have a splat whose triangle some view may show. It reads the parent byte and the size
// word of a splat. The splats of the others are invisible: nothing else of them is read in this frame.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std430, binding = 0) readonly buffer CodeBlock { uint codes[]; };
layout(std430, binding = 1) readonly buffer TriangleBlock { TriangleFrame triangles[]; };
layout(std430, binding = 2) writeonly buffer VisibilityBlock { uint visibility[]; };
layout(push_constant) uniform PushBlock { CodesPush push; };
shared uint live;
#include "shaders/lib/codes.glsl"

void main() {
    uint lane = gl_LocalInvocationIndex;
    SplatPlace p = dplPlaceOf(gl_WorkGroupID.x, lane);
    if (lane == 0u) live = 0u;
    barrier();
    if (p.exists) {
        uint wanted = dplGated(dplSize(p)) ? 3u * kShowsGated : 3u * kShowsFree;
        if ((uint(triangles[dplParent(p)].v0.w) & wanted) != 0u) atomicMax(live, 1u);
    }
    barrier();
    if (lane == 0u) visibility[gl_WorkGroupID.x] = live;
    if (live == 0u && p.exists) visibility[2u * push.groupCount + p.splat] = kInvisibleKey;
}
