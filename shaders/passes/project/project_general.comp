// SPDX-License-Identifier: Apache-2.0
// Footprint, opacity and visibility of general splats: three axes, no gate; another pass computes their colour. The range of depth keys
// comes from the boxes of all groups, seen or not, so that a view is sorted the same alone and in stereo.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/footprint.glsl"
#include "shaders/lib/show.glsl"
#include "shaders/lib/order.glsl"
#include "shaders/lib/views.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
DPL_FOURS(1, SplatBlock, splats);  // GeneralSplatRecords, then one GroupBox for each group
layout(std430, binding = 2) writeonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 3) writeonly buffer VisibilityBlock { uint visibility[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { SplatPush push; };
#include "shaders/lib/visibility.glsl"
#include "shaders/lib/detail.glsl"

bool showIn(ViewData view, uint slot, GeneralSplatRecord s) {
    ProjectedSplat p = dplHiddenSplat();
    Footprint f = projectSolid(dplLens(view), dplToView(view, s.centre.xyz), dplRotateToView(view, s.axis1.xyz), dplRotateToView(view, s.axis2.xyz),
                               dplRotateToView(view, s.axis3.xyz), frame.kappaPx2);
    if (f.visible) {
        float opacity = s.centre.w * nearFade(f.depthM);
        if (frame.compensated != 0u) opacity *= f.compensation;
        p = dplShow(f, opacity, frame.targetPx, frame.cullNothing != 0u);
    }
    projected[slot] = p;
    return dplShown(p.look);
}

/** Width of a pixel in metres at the nearest point of the box, in the view with the smallest pixels. */
float pixelM(vec3 middle, vec3 reach) {
    vec4 a = frame.pixelPlanes[0], b = frame.pixelPlanes[1];
    float nearest = min(nearestPixelM(a.xyz, a.w, middle, reach), nearestPixelM(b.xyz, b.w, middle, reach));
    return nearest > frame.finestPixelM ? nearest : frame.finestPixelM;
}

void main() {
    uint lane = gl_LocalInvocationIndex, group = gl_WorkGroupID.x, box = 4u * push.splatCount + 3u * group;
    // all splats
    vec3 middle = dplFloats(DPL_FOUR(splats, box)).xyz, reach = dplFloats(DPL_FOUR(splats, box + 1u)).xyz, detail = vec3(1.0, 0.0, 1.0);
    if (frame.splatsPerPixel > 0.0) {
        float pixel = pixelM(middle, reach);
        detail = dplFloats(DPL_FOUR(splats, box + 2u)).xyz;
        detail.x = frame.splatsPerPixel * (detail.x / (pixel * pixel));
    }
    SplatShare share = dplShareOf(lane, detail);
    uint index = group * kSplatGroup + share.within;
    if (index < push.splatCount) {
        uint depth = kUnseenDepth;
        if (share.weight > 0.0) {
            bool seen = false;
            GeneralSplatRecord s;
            s.centre = dplFloats(DPL_FOUR(splats, 4u * index));
            s.axis1 = share.growth * dplFloats(DPL_FOUR(splats, 4u * index + 1u));
            s.axis2 = share.growth * dplFloats(DPL_FOUR(splats, 4u * index + 2u));
            s.axis3 = share.growth * dplFloats(DPL_FOUR(splats, 4u * index + 3u));
            s.centre.w *= share.weight;
            for (uint v = 0u; v < kViews; ++v) seen = showIn(frame.views[v], v * frame.splatCount + push.firstSplat + index, s) || seen;
            if (seen) depth = floatBitsToUint(dot(frame.sortAxis, s.centre.xyz));
        } else {
            // read by the colour pass
            for (uint v = 0u; v < kViews; ++v) projected[v * frame.splatCount + push.firstSplat + index].look.y = 0u;
        }
        visibility[dplFirstDepth(push.allGroups) + push.firstSplat + index] = depth;
    }
    if (lane == 0u) {
        visibility[push.firstGroup + group] = 1u;
        visibility[dplFirstRange(push.allGroups) + push.firstGroup + group] = dplRange(push.firstSplat + group * kSplatGroup, min(push.splatCount - group * kSplatGroup, kSplatGroup));
        float there = dot(frame.sortAxis, middle), either = dot(abs(frame.sortAxis), reach);
        atomicMax(counts.depthMaxBits[push.drawn], dplOrderedBits(max(there + either, frame.sortStartM)));
        atomicMax(counts.depthMinBitsInverted[push.drawn], ~dplOrderedBits(max(there - either, frame.sortStartM)));
    }
}
