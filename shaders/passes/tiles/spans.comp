// SPDX-License-Identifier: Apache-2.0
// Writes the spans. A span holds the columns that one splat touches in one row of tiles. Spans are grouped by row, in depth order
// within a row. Where they do not fit, each splat gets one span in each view, with the columns of its bounding box.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/views.glsl"
#include "shaders/lib/projected.glsl"
layout(local_size_x = 32) in;  // kRunGroup

DPL_WORDS(0, OrderBlock, order);
DPL_FOURS(1, ProjectedBlock, projected);  // ProjectedSplat
DPL_WORDS(2, PlaceBlock, places);
layout(std430, binding = 3) writeonly buffer SpanBlock { TileSpan spans[]; };
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/tiles.glsl"

#define DPL_LISTS kMostTiles
#include "shaders/lib/ranks.glsl"

void dplWriteOneForAllRows(uint run, uint end, uint visible) {
    for (uint v = 0u; v < kViews; ++v)
        for (uint i = run * kRun + gl_LocalInvocationIndex; i < end; i += kRunGroup) {
            uint slot = v * push.splatCount + DPL_WORD(order, i);
            ProjectedSplat p = dplRecord(slot);
            float radiusPx = dplEllipseOf(p).radiusXPx;
            uvec2 columns = dplShown(p.opacityAndRadius) ? dplTilesIn(p.centrePx.x - radiusPx - 0.01, p.centrePx.x + radiusPx + 0.01, push.widthPx) : kNoTiles;
            spans[v * visible + i] = TileSpan(slot, columns.x | columns.y << 16u);
        }
}

void main() {
    uint visible = DPL_WORD(places, 0u), runs = DPL_WORD(places, 1u), run = gl_WorkGroupID.x, end = min((run + 1u) * kRun, visible);
    if (DPL_WORD(places, 2u) > push.spanCapacity) {
        dplWriteOneForAllRows(run, end, visible);
        return;
    }
    for (uint v = 0u; v < kViews; ++v) {
        if (v > 0u) barrier();  // lanes are leaving the rows of the view before
        for (uint row = gl_LocalInvocationIndex; row < push.rows; row += kRunGroup)
            dplStartList(row, DPL_WORD(places, push.firstRunTable + (v * push.rows + row) * runs + run));
        barrier();
        for (uint first = run * kRun; first < end; first += kRunGroup) {
            uint i = first + gl_LocalInvocationIndex, slot = v * push.splatCount + DPL_WORD(order, min(i, end - 1u));
            ProjectedSplat p = dplRecord(slot);
            SplatEllipse ellipse = dplEllipseOf(p);
            uvec2 rows = i < end ? dplRowsOf(p, ellipse) : kNoTiles;
            for (uint row = rows.x; row <= rows.y; ++row) dplJoin(row);
            barrier();
            for (uint row = rows.x; row <= rows.y; ++row) {
                uvec2 columns = dplSplatColumns(p.centrePx, ellipse, row, push.widthPx);
                spans[dplPlaceIn(row)] = TileSpan(slot, columns.x | columns.y << 16u);
            }
            barrier();
            for (uint row = rows.x; row <= rows.y; ++row) dplLeave(row);
        }
    }
}
