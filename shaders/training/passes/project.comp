// SPDX-License-Identifier: Apache-2.0
// Projects the splats of the training state: no codes, no level of detail, and all that the backward pass wants to know.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/binding.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) readonly buffer SplatBlock { TrainSplat splats[]; };
layout(std430, binding = 2) readonly buffer ShBlock { float sh[]; };
layout(std430, binding = 3) readonly buffer TriangleBlock { TrainTriangle triangles[]; };
layout(std430, binding = 4) writeonly buffer ScreenBlock { TrainScreen screen[]; };
layout(std430, binding = 5) writeonly buffer RecordBlock { ForwardRecord records[]; };
layout(std430, binding = 6) writeonly buffer PairBlock { uvec2 pairs[]; };  // SortPair

void hide(uint i) {
    screen[i] = TrainScreen(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0u, 0u, 0u);
    pairs[i] = uvec2(kTrainHidden, i);
}

float lit(float unlit, float light) { return unlit > 0.0 ? min(unlit * light, 1.0) : 0.0; }  // NaN becomes black

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= frame.splatCount) return;
    TrainSplat s = splats[i];
    if (s.triangle >= frame.triangleCount || (triangles[s.triangle].flags & kTrainValid) == 0u) {
        hide(i);
        return;
    }
    TriangleFrame t = triangleFrameOf(triangles[s.triangle]);
    Lens lens = frameLens();

    // In view space from the first corner on, so that large world coordinates do not cancel.
    vec3 view = barycentric(viewOf(t.v0), viewTurned(t.v1 - t.v0), viewTurned(t.v2 - t.v0), s.u, s.v);
    vec3 f0 = viewTurned(t.f0), f1 = viewTurned(t.f1);
    PlaneAxes axes = planeAxes(cos(s.phi), sin(s.phi), s.scale1M, s.scale2M);
    Jacobian j = jacobianAt(lens, view);
    vec2 screen0 = axisOnScreen(j, f0), screen1 = axisOnScreen(j, f1);
    vec2 b1 = axes.a10 * screen0 + axes.a11 * screen1, b2 = axes.a20 * screen0 + axes.a21 * screen1;
    Footprint f = footprintOf(lens, j, view.z, flatSpread(b1, b2), frame.kappaPx2);
    float distanceM = length(view), planeDot = dot(t.normal, frame.eye.xyz - t.v0), fade = nearFade(view.z);
    float gate = ((s.flags & kTrainSingleFace) != 0u ? singleFaceGate(planeDot, distanceM) : 1.0) * t.shown;
    float opacity = s.opacity * f.compensation * (fade * gate);

    // Comparisons with NaN are false, so splats with numbers that are not finite are hidden here.
    bool shown = f.visible && t.shown > 0.0 && opacity > kMinAlpha && opacity < 1e30;
    shown = shown && abs(f.centrePx.x) < 1e30 && abs(f.centrePx.y) < 1e30;
    float q = visibleRadius2(shown ? opacity : kMinAlpha);
    vec2 radius = vec2(sqrt(q * f.varianceX), sqrt(q * f.varianceY)), last = vec2(frame.widthPx, frame.heightPx) - 1.0;
    vec2 low = max(ceil(f.centrePx - radius - 0.5), vec2(0.0)), high = min(floor(f.centrePx + radius - 0.5), last);
    if (!(shown && low.x <= high.x && low.y <= high.y)) {
        hide(i);
        return;
    }
    uvec2 first = uvec2(low) / kTrainTilePx, end = uvec2(high) / kTrainTilePx;

    vec3 toSplat = (barycentric(t.v0 - frame.eye.xyz, t.v1 - t.v0, t.v2 - t.v0, s.u, s.v)) * t.worldFromRest;
    float inverseDistance = 1.0 / length(toSplat);
    vec3 direction = inverseDistance * toSplat, unlit = vec3(0.5);
    float basis[16];
    shBasisOf(direction, basis);
    for (uint k = 0u; 3u * k < frame.shFloats; ++k) {
        uint at = i * frame.shFloats + 3u * k;
        unlit += basis[k] * vec3(sh[at], sh[at + 1u], sh[at + 2u]);
    }
    float light = barycentric(t.light.x, t.light.y - t.light.x, t.light.z - t.light.x, s.u, s.v);

    records[i] = ForwardRecord(axes.a10, axes.a11, axes.a20, axes.a21, b1.x, b1.y, b2.x, b2.y, j.slope.x, j.slope.y, j.clampedSlope.x,
                               j.clampedSlope.y, f.depthM, j.inverseZ, axes.a10 * f0.z + axes.a11 * f1.z, axes.a20 * f0.z + axes.a21 * f1.z,
                               f.conicA, f.conicB, f.conicC, f.inverseDet, f.compensation, fade, gate, planeDot / distanceM, direction.x,
                               direction.y, direction.z, inverseDistance, unlit.x, unlit.y, unlit.z, light);
    screen[i] = TrainScreen(f.centrePx.x, f.centrePx.y, f.conicA, f.conicB, f.conicC, opacity, lit(unlit.x, light), lit(unlit.y, light),
                            lit(unlit.z, light), radius.x, radius.y, 1.0 / f.varianceY, (s.flags & kTrainCloth) != 0u ? 1.0 : 0.0,
                            first.x | first.y << 16u, end.x | end.y << 16u, (end.x - first.x + 1u) * (end.y - first.y + 1u));
    pairs[i] = uvec2(floatBitsToUint(view.z), i);  // positive floats order like their bits
}
