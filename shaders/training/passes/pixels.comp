// SPDX-License-Identifier: Apache-2.0
// Backward pass of the blend. A lane takes one entry of a tile's list and adds up its moments over the tile's pixels, so no sum is shared
// and its order is fixed. The pixels travel through the lanes: in each step a lane hands the state of its pixel (transmittance, and the
// part of g·out that lies behind) to the lane of the next entry. Tiles have as many pixels as lanes, so when the last lane has done with
// the first pixel, the first lane takes it again for entry 256: the ring never idles.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/training/lib/train.glsl"
#include "shaders/training/lib/exponent.glsl"
layout(local_size_x = 256) in;  // kTrainTilePixels

layout(std430, binding = 1) readonly buffer OffsetBlock { uint offsets[]; };
layout(std430, binding = 2) readonly buffer EntryBlock { uvec2 entries[]; };
layout(std430, binding = 3) readonly buffer ScreenBlock { TrainScreen screen[]; };
layout(std430, binding = 4) readonly buffer GradientBlock { vec4 gradients[]; };
layout(std430, binding = 5) readonly buffer StopBlock { uint stops[]; };
layout(std430, binding = 6) writeonly buffer EntrySumBlock { TrainEntrySums entrySums[]; };  // by the entry's place by splat

shared vec4 gradient[kTrainTilePixels], rest[kTrainTilePixels];
shared uint stop[kTrainTilePixels];
shared vec2 state[2][kTrainTilePixels];
shared uint used;

void main() {
    uint tile = gl_WorkGroupID.x, lane = gl_LocalInvocationIndex;
    if (tile >= frame.tiles) return;
    uint begin = offsets[tile], count = offsets[tile + 1u] - begin;
    if (count == 0u) return;
    uvec2 corner = uvec2(tile % frame.columns, tile / frame.columns) * kTrainTilePx, at = corner + uvec2(lane % kTrainTilePx, lane / kTrainTilePx);
    bool inside = at.x < frame.widthPx && at.y < frame.heightPx;
    uint i = at.y * frame.widthPx + at.x;
    gradient[lane] = inside ? gradients[2u * i] : vec4(0.0);
    rest[lane] = inside ? gradients[2u * i + 1u] : vec4(0.0);
    stop[lane] = inside ? stops[i] : 0u;
    if (lane == 0u) used = 0u;
    barrier();
    atomicMax(used, stop[lane]);
    barrier();
    uint rounds = (used + kTrainTilePixels - 1u) / kTrainTilePixels;

    uint entry = 0u;
    SplatExponent e = SplatExponent(vec2(0.0), 0.0, 0.0, 0.0, -100.0);
    vec4 colour = vec4(0.0);
    TrainEntrySums own = TrainEntrySums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    const TrainEntrySums kNone = own;
    for (uint time = 0u; time < rounds * kTrainTilePixels + kTrainTilePixels - 1u; ++time) {
        uint passed = time - lane, pixel = passed % kTrainTilePixels, turn = passed / kTrainTilePixels;
        if (time >= lane && turn < rounds) {
            if (pixel == 0u) {
                entry = turn * kTrainTilePixels + lane;
                own = kNone;
                e.logOpacity = -100.0;  // an entry that is none touches nothing
                e.scale = e.rowScale = 0.0;
                if (entry < count) {
                    TrainScreen p = screen[entries[begin + entry].x];
                    e = splatExponent(p);
                    colour = vec4(p.red, p.green, p.blue, p.cloth);
                }
            }
            vec2 s = vec2(1.0, rest[pixel].w);
            if (turn > 0u || lane > 0u) s = state[(time + 1u) % 2u][(lane + kTrainTilePixels - 1u) % kTrainTilePixels];
            vec2 offset = vec2(corner + uvec2(pixel % kTrainTilePx, pixel / kTrainTilePx)) + 0.5 - e.centrePx;
            float exponent = exponentAt(e, offset);
            if (exponent >= kLog2MinAlpha && entry < stop[pixel]) {
                bool isCloth = colour.w > 0.5;
                vec4 g = gradient[pixel];
                float cover = isCloth ? rest[pixel].x : g.w, share = isCloth ? rest[pixel].z : rest[pixel].y;
                float raw = exp2(exponent), alpha = min(raw, kMaxAlpha), v = dot(g.rgb, colour.rgb) + cover;
                float weight = alpha * s.x, through = 1.0 - alpha, behind = s.y - weight * v;
                own.red += weight * share * g.r;
                own.green += weight * share * g.g;
                own.blue += weight * share * g.b;
                own.weight += weight;
                float gSigma = raw <= kMaxAlpha ? alpha * behind / through - weight * v : 0.0;
                vec2 moment = gSigma * offset;
                own.s += gSigma;
                own.sx += moment.x;
                own.sy += moment.y;
                own.sxx += moment.x * offset.x;
                own.sxy += moment.x * offset.y;
                own.syy += moment.y * offset.y;
                s = vec2(s.x * through, behind);
            }
            state[time % 2u][lane] = s;
            if (pixel == kTrainTilePixels - 1u && entry < count) entrySums[entries[begin + entry].y] = own;
        }
        barrier();
    }
    for (uint unused = rounds * kTrainTilePixels + lane; unused < count; unused += kTrainTilePixels)
        entrySums[entries[begin + unused].y] = kNone;
}
