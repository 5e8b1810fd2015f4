// SPDX-License-Identifier: Apache-2.0
// Blends the splats of a tile, nearest first; one lane a pixel. An entry is blended while the pixel's transmittance is above
// kMinTransmittance.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/exponent.glsl"
layout(local_size_x = 256) in;  // kTrainTilePixels

layout(std430, binding = 1) readonly buffer OffsetBlock { uint offsets[]; };
layout(std430, binding = 2) readonly buffer EntryBlock { uvec2 entries[]; };
layout(std430, binding = 3) readonly buffer ScreenBlock { TrainScreen screen[]; };
layout(std430, binding = 4) writeonly buffer ImageBlock { vec4 image[]; };  // premultiplied colour, transmittance
layout(std430, binding = 5) writeonly buffer ClothBlock { float cloths[]; };
layout(std430, binding = 6) writeonly buffer StopBlock { uint stops[]; };  // entries of the tile up to the last one that was blended

shared vec4 exponents[kTrainBatch];  // centre, slope, scale
shared vec4 rows[kTrainBatch];       // row scale, log opacity, cloth
shared vec4 colours[kTrainBatch];
shared uint live;

void main() {
    uint tile = gl_WorkGroupID.x, lane = gl_LocalInvocationIndex;
    if (tile >= frame.tiles) return;
    uint begin = offsets[tile], end = offsets[tile + 1u];
    uvec2 at = uvec2(tile % frame.columns, tile / frame.columns) * kTrainTilePx + uvec2(lane % kTrainTilePx, lane / kTrainTilePx);
    bool inside = at.x < frame.widthPx && at.y < frame.heightPx;
    vec2 pixel = vec2(at) + 0.5;
    float transmittance = inside ? 1.0 : 0.0, cloth = 0.0;
    vec3 colour = vec3(0.0);
    uint stop = 0u;
    for (uint batch = begin; batch < end; batch += kTrainBatch) {
        barrier();
        if (lane == 0u) live = 0u;
        if (lane < kTrainBatch && batch + lane < end) {
            TrainScreen p = screen[entries[batch + lane].x];
            SplatExponent e = splatExponent(p);
            exponents[lane] = vec4(e.centrePx, e.slope, e.scale);
            rows[lane] = vec4(e.rowScale, e.logOpacity, p.cloth, 0.0);
            colours[lane] = vec4(p.red, p.green, p.blue, 0.0);
        }
        barrier();
        if (transmittance > kMinTransmittance) atomicOr(live, 1u);
        barrier();
        if (live == 0u) break;
        uint count = min(kTrainBatch, end - batch);
        for (uint k = 0u; k < count; ++k) {
            vec4 e = exponents[k], row = rows[k];
            float exponent = exponentAt(SplatExponent(e.xy, e.z, e.w, row.x, row.y), pixel - e.xy);
            if (!(exponent >= kLog2MinAlpha && transmittance > kMinTransmittance)) continue;
            float weight = min(exp2(exponent), kMaxAlpha) * transmittance;
            colour += weight * colours[k].rgb;
            cloth += weight * row.z;
            transmittance -= weight;
            stop = batch + k + 1u - begin;
        }
    }
    if (!inside) return;
    uint i = at.y * frame.widthPx + at.x;
    image[i] = vec4(colour, transmittance);
    cloths[i] = cloth;
    stops[i] = stop;
}
