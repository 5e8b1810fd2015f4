// SPDX-License-Identifier: Apache-2.0
// Footprint, opacity, colour and visibility of the splats of one live group in every view, and the sort depth of the splats that some
// view shows.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/footprint.glsl"
#include "sdk/math/formulas/binding.inl"
#include "shaders/lib/show.glsl"
#include "shaders/lib/views.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
DPL_WORDS(1, CodeBlock, codes);
DPL_FOURS(2, TriangleBlock, triangles);  // TriangleFrame
layout(std430, binding = 3) writeonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 4) buffer VisibilityBlock { uint visibility[]; };
layout(push_constant) uniform PushBlock { CodesPush push; };
#include "shaders/lib/visibility.glsl"
#include "shaders/lib/sh_degree.glsl"
#include "shaders/lib/codes.glsl"
#include "shaders/lib/detail.glsl"
#include "shaders/lib/triangle_frame.glsl"

vec3 dplSh(uint base, uint k) {
    if (k > 0u && frame.shShare <= 0.0) return vec3(0.0);  // their coefficients were not fetched
    return k > 0u ? frame.shShare * dplShCode(k) : dplShCode(k);
}
#include "shaders/lib/sh.glsl"

struct BoundSplat {
    uint index;
    uint turnXY, turnZW;  // polar rotation of its triangle, packed as in TriangleFrame
    bool gated;
    float opacity, light;
    vec3 centre, axis1, axis2, normal;
};

ProjectedSplat showIn(ViewData view, BoundSplat s, bool mayShow) {
    ProjectedSplat p = dplHiddenSplat();
    if (mayShow) {
        Footprint f = projectFlat(dplLens(view), dplToView(view, s.centre), dplRotateToView(view, s.axis1), dplRotateToView(view, s.axis2), frame.kappaPx2);
        if (f.visible) {
            float opacity = s.opacity * nearFade(f.depthM);
            if (frame.compensated != 0u) opacity *= f.compensation;
            if (s.gated) opacity *= dplSingleFaceGate(s.normal, s.centre, dplEyeWorld(view));
            p = dplShow(f, opacity, frame.targetPx);
        }
    }
    return p;
}

/** Colour of the fetched splat in the view. */
uint shadeIn(ViewData view, BoundSplat s) {
    vec3 rest = vec3(0.0);
    if (kShDegree > 0u) {  // direction from the eye to the splat, turned into the rest frame of its triangle
        vec4 turn = vec4(unpackSnorm2x16(s.turnXY), unpackSnorm2x16(s.turnZW));
        vec3 world = s.centre - dplEyeWorld(view);
        rest = normalize(world + 2.0 * cross(turn.xyz, cross(turn.xyz, world) - turn.w * world));
    }
    return dplPackColour(dplShColour(rest, 0u, s.light));
}

void main() {
    uint lane = gl_LocalInvocationIndex, group = visibility[dplFirstLive(push.allGroups) + push.firstGroup + gl_WorkGroupID.x];
    dplFirstChunkWord = (group >> 1u) * kChunkWords;
    uint firstSplat = dplFirstOf(group);
    WantedDetail detail = WantedDetail(1.0, 0.0, 1.0);  // all splats
    if (frame.splatsPerM2 > 0.0) {
        uint at = push.firstGroupDetail + 3u * group;
        float areaM2 = uintBitsToFloat(DPL_WORD(codes, at)), gain = uintBitsToFloat(DPL_WORD(codes, at + 1u)), enough = uintBitsToFloat(DPL_WORD(codes, at + 2u));
        detail = WantedDetail(frame.splatsPerM2 * areaM2, gain, enough);
    }
    SplatShare share = dplShareOf(lane, detail);
    if (share.within >= dplCountOf(group)) return;
    BoundSplat s;
    s.index = firstSplat + share.within;
    uint depth = kUnseenDepth;
    if (share.weight > 0.0) {
        uint size = DPL_WORD(codes, push.firstSize + s.index);
        s.gated = dplGated(size);
        uint parent = kTriangleFrameFours * dplParent(s.index);
        uvec4 corner0 = DPL_FOUR(triangles, parent);
        uint shown = dplShows(corner0) & (s.gated ? 3u * kShowsGated : 3u * kShowsFree);
        if (shown == 0u) {  // its triangle is out of view or turned away: nothing else of the splat is read
            for (uint v = 0u; v < kViews; ++v) projected[v * frame.splatCount + push.firstSplat + s.index].opacityAndRadius = 0u;
        } else {
            uint packed = DPL_WORD(codes, push.firstPlace + s.index);
            vec2 scale = share.growth * dplScale(size);
            float phi = float(packed >> 22u) * kPhiCodeStep;
            vec2 uv = dplUv(packed);
            TriangleFrame t = dplTriangleFrame(corner0, DPL_FOUR(triangles, parent + 1u), DPL_FOUR(triangles, parent + 2u), DPL_FOUR(triangles, parent + 3u), DPL_FOUR(triangles, parent + 4u));
            vec3 v0 = vec3(t.corner0X, t.corner0Y, t.corner0Z), v1 = vec3(t.corner1X, t.corner1Y, t.corner1Z), v2 = vec3(t.corner2X, t.corner2Y, t.corner2Z);
            vec3 f0 = vec3(t.column0X, t.column0Y, t.column0Z), f1 = vec3(t.column1X, t.column1Y, t.column1Z);
            vec2 light01 = unpackHalf2x16(t.light01), light2AndHidden = unpackHalf2x16(t.light2);
            s.opacity = share.weight * dplOpacity(size) * (1.0 - light2AndHidden.y);
            s.light = barycentric(light01.x, light01.y - light01.x, light2AndHidden.x - light01.x, uv.x, uv.y);
            s.turnXY = t.turnXY;
            s.turnZW = t.turnZW;
            s.centre = barycentric(v0, v1 - v0, v2 - v0, uv.x, uv.y);
            PlaneAxes a = planeAxes(cos(phi), sin(phi), scale.x, scale.y);
            s.axis1 = a.a10 * f0 + a.a11 * f1;
            s.axis2 = a.a20 * f0 + a.a21 * f1;
            s.normal = normalize(cross(f0, f1));
            ProjectedSplat p[kViews];
            bool seen = false;
            for (uint v = 0u; v < kViews; ++v) {
                p[v] = showIn(frame.views[v], s, (shown & ((kShowsFree | kShowsGated) << v)) != 0u);
                seen = seen || dplShown(p[v].opacityAndRadius);
            }
            if (seen) {
                dplFetchSh(s.index, frame.shShare > 0.0);
                for (uint v = 0u; v < kViews; ++v) p[v].colour = shadeIn(frame.views[v], s);
                depth = floatBitsToUint(dot(vec3(frame.sortAxisX, frame.sortAxisY, frame.sortAxisZ), s.centre) + frame.sortOffsetM);
            }
            for (uint v = 0u; v < kViews; ++v) {
                uint slot = v * frame.splatCount + push.firstSplat + s.index;
                projected[slot] = p[v];
            }
        }
    }
    visibility[dplFirstDepth(push.allGroups) + push.firstSplat + s.index] = depth;
}
