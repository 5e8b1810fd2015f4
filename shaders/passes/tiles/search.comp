// SPDX-License-Identifier: Apache-2.0
// Fills a frame whose lists were too small: neighbouring tiles of a row go through the row's spans, or through all splats where even the
// spans did not fit, and composite what touches them. The pixels are those of fill.comp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/pairs.glsl"
#include "shaders/lib/projected.glsl"
#include "sdk/math/formulas/constants.h"
layout(local_size_x = 64) in;  // kTileGroup

DPL_WORDS(0, PlaceBlock, places);
DPL_PAIRS(1, SpanBlock, spans);           // TileSpan
DPL_FOURS(2, ProjectedBlock, projected);  // ProjectedSplat
#ifdef DPL_SCENE_DEPTH
#define DPL_PIXEL_ACCESS
#else
#define DPL_PIXEL_ACCESS writeonly
#endif
layout(std430, binding = 3) DPL_PIXEL_ACCESS buffer PixelBlock { uint pixels[]; };
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/tiles.glsl"
#include "shaders/lib/tile_pixels.glsl"

const uint kTogether = kTileGroup / kSide;  // tiles of a workgroup
const uint kWords = kTileGroup / 32u;       // with a bit for each lane
shared uint records[kTileGroup];            // that the lanes looked at
shared uint touching[kTogether * kWords];   // for each tile, which of them touch it
shared uint lit;                            // 1: some column is not used up

/** Which of the tiles first to last of a row a splat touches. all: the span stands for all rows of the splat. */
uvec2 dplColumnsOf(TileSpan span, bool all, uint row, uint first, uint last) {
    uvec2 columns = uvec2(dplFirstColumn(span.columns), dplLastColumn(span.columns));
    columns = uvec2(max(columns.x, first), min(columns.y, last));
    if (!all || columns.x > columns.y) return columns;
    ProjectedSplat p = dplRecord(span.record);
    SplatEllipse ellipse = dplEllipseOf(p);
    uvec2 rows = dplRowsOf(p, ellipse);
    if (row < rows.x || row > rows.y) return kNoTiles;
    columns = dplSplatColumns(p.centrePx, ellipse, row, push.widthPx);
    return uvec2(max(columns.x, first), min(columns.y, last));
}

void main() {
    uint visible = DPL_WORD(places, 0u), runs = DPL_WORD(places, 1u), spanCount = DPL_WORD(places, 2u);
    bool all = spanCount > push.spanCapacity;
    uint lane = gl_LocalInvocationIndex, own = lane / kSide, across = (push.columns + kTogether - 1u) / kTogether;
    uint rows = push.viewCount * push.rows;
    for (uint strip = gl_WorkGroupID.x; strip < rows * across; strip += push.fillGroups) {
        uint row = strip / across, view = row / push.rows, rowOfView = row % push.rows, first = strip % across * kTogether;
        uint begin = view * visible, end = begin + visible;
        if (!all) {
            uint cell = push.firstRunTable + row * runs;
            begin = DPL_WORD(places, cell);
            end = row + 1u < rows ? DPL_WORD(places, cell + runs) : spanCount;
        }
        uint x = (first + own) * kSide + lane % kSide, y = rowOfView * kSide;
        dplStartColumn(view, x, y);
        if (x >= push.widthPx) live = 0.0;
        uint added = 0u;
        for (uint batch = begin; batch < end; batch += kTileGroup) {
            for (uint k = lane; k < kTogether * kWords; k += kTileGroup) touching[k] = 0u;
            barrier();
            if (lane == 0u) lit = 0u;
            if (batch + lane < end) {
                TileSpan span = dplTileSpan(DPL_PAIR(spans, batch + lane));
                uvec2 columns = dplColumnsOf(span, all, rowOfView, first, first + kTogether - 1u);
                records[lane] = span.record;
                for (uint column = columns.x; column <= columns.y; ++column)
                    atomicOr(touching[(column - first) * kWords + lane / 32u], 1u << lane % 32u);
            }
            barrier();
            for (uint word = 0u; word < kWords; ++word) {
                for (uint bits = touching[own * kWords + word]; bits != 0u && live > 0.0; bits &= bits - 1u) {
                    ProjectedSplat p = dplRecord(records[32u * word + uint(findLSB(bits))]);
                    dplAddSplat(p, exp(-p.conicC), dplOpacityOf(p.opacityAndRadius));
                    if (++added % kBatch == 0u) dplLookThrough();
                }
            }
            if (live > 0.0) atomicOr(lit, 1u);
            barrier();
            if (lit == 0u) break;
        }
        dplWriteColumn(view, x, y);
    }
}
