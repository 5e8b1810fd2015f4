// SPDX-License-Identifier: Apache-2.0
// From the sums of a splat's entries to the gradient of its row, and its part of the gradients of its triangle.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/binding.glsl"
#include "shaders/training/lib/backward.glsl"
layout(local_size_x = 128) in;  // kTrainGroup

layout(std430, binding = 1) readonly buffer SplatBlock { TrainSplat splats[]; };
layout(std430, binding = 2) readonly buffer ShBlock { float sh[]; };
layout(std430, binding = 3) readonly buffer TriangleBlock { TrainTriangle triangles[]; };
layout(std430, binding = 4) readonly buffer ScreenBlock { TrainScreen screen[]; };
layout(std430, binding = 5) readonly buffer RecordBlock { ForwardRecord records[]; };
layout(std430, binding = 6) readonly buffer FirstBlock { uint firsts[]; };
layout(std430, binding = 7) readonly buffer EntrySumBlock { TrainEntrySums entrySums[]; };
layout(std430, binding = 8) readonly buffer ConstantBlock { TrainTriangleConstants constants[]; };
layout(std430, binding = 9) readonly buffer CountsBlock { uint counts[]; };  // FrameCounts, whose header names a TriangleFrame of its own
layout(std430, binding = 10) writeonly buffer RowBlock { float rows[]; };      // gradients; columns as in trainable.h
layout(std430, binding = 11) writeonly buffer ShownBlock { float shown[]; };   // |gradient on the centre|, per pixel; negative: inactive
layout(std430, binding = 12) writeonly buffer PartBlock { vec4 parts[]; };         // kTrainTriangleFours a splat

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= frame.splatCount) return;
    TrainScreen p = screen[i];
    TrainEntrySums sum = TrainEntrySums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    uint entryCount = counts[kTrainEntriesWord] <= frame.entryCapacity ? p.tileCount : 0u;  // lists that were too short hold nothing
    for (uint k = 0u; k < entryCount; ++k) {
        TrainEntrySums e = entrySums[firsts[i] + k];
        sum.s += e.s;
        sum.sx += e.sx;
        sum.sy += e.sy;
        sum.sxx += e.sxx;
        sum.sxy += e.sxy;
        sum.syy += e.syy;
        sum.red += e.red;
        sum.green += e.green;
        sum.blue += e.blue;
        sum.weight += e.weight;
    }
    if (!(sum.weight > 0.0)) {
        shown[i] = -1.0;
        for (uint k = 0u; k < kTrainTriangleFours; ++k) parts[kTrainTriangleFours * i + k] = vec4(0.0);
        return;
    }
    TrainSplat s = splats[i];
    TriangleFrame t = triangleFrameOf(triangles[s.triangle]);
    ForwardRecord f = records[i];
    BackwardView view;
    view.lens = frameLens();
    view.worldFromView = mat3(frame.viewFromWorldRow0.xyz, frame.viewFromWorldRow1.xyz, frame.viewFromWorldRow2.xyz);
    FootprintGradient g =
        footprintGradient(p.conicA, p.conicB, p.conicC, p.opacity, sum.s, sum.sx, sum.sy, sum.sxx, sum.sxy, sum.syy);
    WorldGradient world = footprintBackward(view, t, s.opacity, (s.flags & kTrainSingleFace) != 0u, f, g);
    ColourGradient colour = colourBackward(f, vec3(sum.red, sum.green, sum.blue));

    vec3 direction = vec3(f.directionX, f.directionY, f.directionZ);
    float basis[16], weight[16];
    shBasisOf(direction, basis);
    uint row = i * frame.rowFloats;
    for (uint k = 0u; k < 16u; ++k) {
        weight[k] = 0.0;
        if (3u * k >= frame.shFloats) continue;
        uint at = i * frame.shFloats + 3u * k;
        weight[k] = sh[at] * colour.unlit.x + sh[at + 1u] * colour.unlit.y + sh[at + 2u] * colour.unlit.z;
        for (uint c = 0u; c < 3u; ++c) rows[row + 6u + 3u * k + c] = basis[k] * colour.unlit[c];
    }
    if (frame.shDegree > 0u) {
        vec3 gRest = shBand1Gradient(ShBand1(weight[1], weight[2], weight[3])) +
                     shBand2Gradient(direction, ShBand2(weight[4], weight[5], weight[6], weight[7], weight[8])) +
                     shBand3Gradient(direction, ShBand3(weight[9], weight[10], weight[11], weight[12], weight[13], weight[14], weight[15]));
        world = directionBackward(world, t, f, gRest);
    }
    PlacementGradient place = placementBackward(t, f, world, colour.light);
    float floorM = constants[s.triangle].floorM, floor2 = floorM * floorM, first2 = s.scale1M * s.scale1M, second2 = s.scale2M * s.scale2M;
    rows[row] = place.uv.x;
    rows[row + 1u] = place.uv.y;
    rows[row + 2u] = place.phi;
    rows[row + 3u] = place.logScale.x * max(0.0, first2 - floor2) / first2;
    rows[row + 4u] = place.logScale.y * max(0.0, second2 - floor2) / second2;
    rows[row + 5u] = world.opacity * s.opacity * (1.0 - s.opacity);
    for (uint k = 6u + frame.shFloats; k < frame.rowFloats; ++k) rows[row + k] = 0.0;
    shown[i] = length(vec2(g.x, g.y));

    vec3 f0 = f.a10 * world.axis1 + f.a20 * world.axis2, f1 = f.a11 * world.axis1 + f.a21 * world.axis2;
    vec3 corner = vec3(1.0 - s.u - s.v, s.u, s.v), light = colour.light * corner;
    uint part = kTrainTriangleFours * i;
    parts[part] = vec4(f0, world.shown);
    parts[part + 1u] = vec4(f1, light.x);
    parts[part + 2u] = vec4(world.turn, light.y);
    parts[part + 3u] = vec4(corner.x * world.centre, light.z);
    parts[part + 4u] = vec4(corner.y * world.centre, 0.0);
    parts[part + 5u] = vec4(corner.z * world.centre, 0.0);
}
