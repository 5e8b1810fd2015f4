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
DPL_FOURS(1, SplatBlock, splats);  // lib/general_splat.glsl
layout(std430, binding = 2) writeonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 3) writeonly buffer VisibilityBlock { uint visibility[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { SplatPush push; };
#include "shaders/lib/visibility.glsl"
#include "shaders/lib/detail.glsl"
#include "shaders/lib/general_splat.glsl"

struct GeneralSplat {
    float opacity;
    vec3 centre, axis1, axis2, axis3;
};

bool showIn(ViewData view, uint slot, GeneralSplat s) {
    ProjectedSplat p = dplHiddenSplat();
    Footprint f = projectSolid(dplLens(view), dplToView(view, s.centre), dplRotateToView(view, s.axis1), dplRotateToView(view, s.axis2),
                               dplRotateToView(view, s.axis3), frame.kappaPx2);
    if (f.visible) {
        float opacity = s.opacity * nearFade(f.depthM);
        if (frame.compensated != 0u) opacity *= f.compensation;
        p = dplShow(f, opacity, frame.targetPx);
    }
    projected[slot] = p;
    return dplShown(p.opacityAndRadius);
}

/** Width of a pixel in metres at the nearest point of the box. */
float pixelOfViewM(PixelPlane p, vec3 middle, vec3 reach) { return nearestPixelM(vec3(p.axisX, p.axisY, p.axisZ), p.offsetM, middle, reach); }

/** The same in the view with the smallest pixels. */
float pixelM(vec3 middle, vec3 reach) {
    float nearest = min(pixelOfViewM(frame.pixelPlanes[0], middle, reach), pixelOfViewM(frame.pixelPlanes[1], middle, reach));
    return nearest > frame.finestPixelM ? nearest : frame.finestPixelM;
}

void main() {
    uint lane = gl_LocalInvocationIndex, group = gl_WorkGroupID.x;
    GroupBox box = dplGroupBox(push.splatCount, group);
    vec3 middle = vec3(box.middleX, box.middleY, box.middleZ), reach = vec3(box.reachX, box.reachY, box.reachZ);
    vec3 sortAxis = vec3(frame.sortAxisX, frame.sortAxisY, frame.sortAxisZ);
    WantedDetail detail = WantedDetail(1.0, 0.0, 1.0);  // all splats
    if (frame.splatsPerPixel > 0.0) {
        float pixel = pixelM(middle, reach);
        detail = WantedDetail(frame.splatsPerPixel * (box.areaM2 / (pixel * pixel)), box.gain, box.enough);
    }
    SplatShare share = dplShareOf(lane, detail);
    uint index = group * kSplatGroup + share.within;
    if (index < push.splatCount) {
        uint depth = kUnseenDepth;
        if (share.weight > 0.0) {
            bool seen = false;
            GeneralSplatRecord r = dplGeneralSplat(index);
            GeneralSplat s;
            s.opacity = share.weight * r.opacity;
            s.centre = dplCentreOf(r);
            s.axis1 = share.growth * vec3(r.axis1X, r.axis1Y, r.axis1Z);
            s.axis2 = share.growth * vec3(r.axis2X, r.axis2Y, r.axis2Z);
            s.axis3 = share.growth * vec3(r.axis3X, r.axis3Y, r.axis3Z);
            for (uint v = 0u; v < kViews; ++v) seen = showIn(frame.views[v], v * frame.splatCount + push.firstSplat + index, s) || seen;
            if (seen) depth = floatBitsToUint(dot(sortAxis, s.centre) + frame.sortOffsetM);
        } else {
            // read by the colour pass
            for (uint v = 0u; v < kViews; ++v) projected[v * frame.splatCount + push.firstSplat + index].opacityAndRadius = 0u;
        }
        visibility[dplFirstDepth(push.allGroups) + push.firstSplat + index] = depth;
    }
    if (lane == 0u) {
        visibility[push.firstGroup + group] = 1u;
        visibility[dplFirstRange(push.allGroups) + push.firstGroup + group] = dplRange(push.firstSplat + group * kSplatGroup, min(push.splatCount - group * kSplatGroup, kSplatGroup));
        float there = dot(sortAxis, middle) + frame.sortOffsetM, either = dot(abs(sortAxis), reach);
        atomicMax(counts.depthMaxBits[push.drawn], dplOrderedBits(max(there + either, frame.sortStartM)));
        atomicMax(counts.depthMinBitsInverted[push.drawn], ~dplOrderedBits(max(there - either, frame.sortStartM)));
    }
}
