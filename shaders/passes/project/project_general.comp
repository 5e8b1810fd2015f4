// The same for general splats: three axes, no gate; their colour is another pass. Nothing poses them, so their extent along the sort axis, the range
// of the depth keys, is that of the boxes about their groups: of all splats, seen or not, so that two views sort as each alone.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/footprint.glsl"
#include "shaders/lib/projected.glsl"
#include "shaders/lib/order.glsl"
#include "shaders/lib/views.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
DPL_FOURS(1, SplatBlock, splats);  // GeneralSplatRecord; behind them a GroupBox a group
layout(std430, binding = 2) writeonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 3) writeonly buffer VisibilityBlock { uint visibility[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { SplatPush push; };
#define DPL_SEEN
#include "shaders/lib/visibility.glsl"

bool showIn(ViewData view, uint slot, GeneralSplatRecord s) {
    ProjectedSplat p = dplHiddenSplat();
    Footprint f = dplProjectGeneral(view, dplToView(view, s.centre.xyz), dplRotateToView(view, s.axis1.xyz), dplRotateToView(view, s.axis2.xyz),
                                    dplRotateToView(view, s.axis3.xyz), frame.target.z);
    if (f.visible) {
        float opacity = s.centre.w * dplNearFade(f.depthM);
        if (frame.flags.x != 0u) opacity *= f.compensation;
        p = dplShow(f, opacity, frame.target.xy, frame.flags.z != 0u);
    }
    projected[slot].place = p.place;
    projected[slot].look = p.look;
    projected[slot].radiusPx = p.radiusPx;
    return p.radiusPx.y > 0.0;
}

void main() {
    uint lane = gl_LocalInvocationIndex, group = gl_WorkGroupID.x, index = group * kSplatGroup + lane;
    dplClearSeen(lane);
    barrier();
    if (index < push.splatCount) {
        GeneralSplatRecord s;
        s.centre = dplFloats(DPL_FOUR(splats, 4u * index));
        s.axis1 = dplFloats(DPL_FOUR(splats, 4u * index + 1u));
        s.axis2 = dplFloats(DPL_FOUR(splats, 4u * index + 2u));
        s.axis3 = dplFloats(DPL_FOUR(splats, 4u * index + 3u));
        bool seen = false;
        for (uint v = 0u; v < kViews; ++v) seen = showIn(frame.views[v], v * frame.flags.w + push.firstSplat + index, s) || seen;
        if (seen) {
            visibility[dplFirstDepth(push.allGroups) + push.firstSplat + index] = floatBitsToUint(dot(frame.sortAxis.xyz, s.centre.xyz));
            dplSee(lane);
        }
    }
    barrier();
    dplWriteSeen(lane, push.allGroups, push.firstGroup + group, push.firstSplat + group * kSplatGroup);
    if (lane == 0u) {
        uint box = 4u * push.splatCount + 2u * group;
        float middle = dot(frame.sortAxis.xyz, dplFloats(DPL_FOUR(splats, box)).xyz), reach = dot(abs(frame.sortAxis.xyz), dplFloats(DPL_FOUR(splats, box + 1u)).xyz);
        atomicMax(counts.depthMaxBits[push.drawn], dplOrderedBits(max(middle + reach, frame.sortAxis.w)));
        atomicMax(counts.depthMinBitsInverted[push.drawn], ~dplOrderedBits(max(middle - reach, frame.sortAxis.w)));
    }
}
