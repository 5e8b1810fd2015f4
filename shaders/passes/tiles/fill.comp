// SPDX-License-Identifier: Apache-2.0
// Composites the pixels of each tile from its list, nearest first. One lane owns one column of a tile. It takes four splats at a time
// (two at four samples) and stops when the transmittance of all its samples is used up.
// DPL_SHUFFLE: the eight (four) lanes of a tile fetch together: each pair of lanes loads one record, half each, and shares it by
// shuffles. For devices whose subgroups hold whole tiles (DeviceInfo::shuffle); the picture is the same but for rounding.
#version 450
#extension GL_GOOGLE_include_directive : require
#ifdef DPL_SHUFFLE
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/projected.glsl"
#include "sdk/math/formulas/constants.h"
layout(local_size_x = 64) in;  // kTileGroup

DPL_WORDS(0, PlaceBlock, places);
DPL_WORDS(1, EntryBlock, entries);
DPL_FOURS(2, ProjectedBlock, projected);  // ProjectedSplat
#ifdef DPL_SCENE_DEPTH
#define DPL_PIXEL_ACCESS
#else
#define DPL_PIXEL_ACCESS writeonly
#endif
layout(std430, binding = 3) DPL_PIXEL_ACCESS buffer PixelBlock { uint pixels[]; };  // a tile without entries is not written
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/tile_pixels.glsl"

void main() {
    uint tileCount = push.viewCount * push.rows * push.columns;
    for (uint tile = gl_GlobalInvocationID.x / kSide; tile < tileCount; tile += push.fillGroups * (kTileGroup / kSide)) {
        uint row = tile / push.columns, end = DPL_WORD(places, push.firstTileTable + (tile + 1u) * kTileSegments - 1u);
        uint begin = tile == 0u ? 0u : DPL_WORD(places, push.firstTileTable + tile * kTileSegments - 1u);
        if (begin == end) continue;
        uint view = row / push.rows, x = (tile % push.columns) * kSide + gl_GlobalInvocationID.x % kSide, y = (row % push.rows) * kSide;
        dplStartColumn(view, x, y);
#ifdef DPL_SHUFFLE
        uint lane = gl_LocalInvocationIndex % kSide, firstLane = gl_SubgroupInvocationID - lane;
        for (uint batch = begin; batch < end; batch += kBatch) {
            uvec4 mine = DPL_FOUR(projected, kProjectedFours * DPL_WORD(entries, min(batch + lane / 2u, end - 1u)) + lane % 2u);
            ProjectedSplat odd = dplProjected(uvec4(0u), mine);  // meaningful only in lanes that hold the second half of a record
            float bendOf = exp(-odd.conicC), opacityOf = dplOpacityOf(odd.opacityAndRadius);
            for (uint j = 0u; j < kBatch; ++j) {
                uint first = firstLane + 2u * j, second = first + 1u;
                ProjectedSplat p = dplProjected(
                    uvec4(subgroupShuffle(mine.x, first), subgroupShuffle(mine.y, first), subgroupShuffle(mine.z, first), subgroupShuffle(mine.w, first)),
                    uvec4(subgroupShuffle(mine.x, second), 0u, subgroupShuffle(mine.z, second), subgroupShuffle(mine.w, second)));
                // past the end of the list the last record is fetched again, with opacity 0
                float bend = subgroupShuffle(bendOf, second), opacity = batch + j < end ? live * subgroupShuffle(opacityOf, second) : 0.0;
                dplAddSplat(p, bend, opacity);
            }
            dplLookThrough();
            float any = live;
            for (uint step = 1u; step < kSide; step *= 2u) any = max(any, subgroupShuffleXor(any, step));
            if (any == 0.0) break;
        }
#else
        for (uint batch = begin; batch < end && live > 0.0; batch += kBatch) {
            for (uint i = batch; i < min(batch + kBatch, end); ++i) {
                uint record = kProjectedFours * DPL_WORD(entries, i);
                ProjectedSplat p = dplProjected(DPL_FOUR(projected, record), DPL_FOUR(projected, record + 1u));
                dplAddSplat(p, exp(-p.conicC), dplOpacityOf(p.opacityAndRadius));
            }
            dplLookThrough();
        }
#endif
        dplWriteColumn(view, x, y);
    }
}
