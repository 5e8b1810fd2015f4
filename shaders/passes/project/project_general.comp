// The same for general splats: three axes, no gate. Nothing poses them, so their extent along the sort axis, the range of the depth keys, is
// found here: of all splats, seen or not, so that two views sort as each alone.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/footprint.glsl"
#include "shaders/lib/order.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer SplatBlock { GeneralSplatRecord splats[]; };
layout(std430, binding = 2) writeonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 3) writeonly buffer DepthBlock { uint sortDepth[]; };  // float bits, kInvisibleKey = in no view
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { SplatPush push; };

shared uint groupMax;
shared uint groupMinInverted;

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint index = gl_WorkGroupID.x * kSplatGroup + lane;
    if (lane == 0u) {
        groupMax = 0u;
        groupMinInverted = 0u;
    }
    barrier();
    if (index < push.splatCount) {
        GeneralSplatRecord s = splats[index];
        bool seen = false;
        for (uint v = 0u; v < push.viewCount; ++v) {
            ViewData view = frame.views[v];
            ProjectedSplat p = dplHiddenSplat();
            Footprint f = dplProjectGeneral(view, dplToView(view, s.centre.xyz), dplRotateToView(view, s.axis1.xyz), dplRotateToView(view, s.axis2.xyz),
                                            dplRotateToView(view, s.axis3.xyz), frame.target.z);
            if (f.visible) {
                float opacity = s.centre.w * dplNearFade(f.depthM);
                if (frame.counts.w != 0u) opacity *= f.compensation;
                p = dplShow(f, opacity, frame.target.xy);
                seen = seen || p.opacity > 0.0;
            }
            projected[index * push.viewCount + v] = p;
        }
        float depth = dot(frame.sortAxis.xyz, s.centre.xyz);
        sortDepth[index] = seen ? floatBitsToUint(depth) : kInvisibleKey;
        atomicMax(groupMax, dplOrderedBits(depth));
        atomicMax(groupMinInverted, ~dplOrderedBits(depth));
    }
    barrier();
    if (lane == 0u) {
        atomicMax(counts.depthMaxBits, groupMax);
        atomicMax(counts.depthMinBitsInverted, groupMinInverted);
    }
}
