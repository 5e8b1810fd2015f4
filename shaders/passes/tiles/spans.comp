// SPDX-License-Identifier: Apache-2.0
// Writes the spans. A span holds the columns that one splat touches in one row of tiles. Spans are grouped by row, in depth order
// within a row.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/views.glsl"
#include "shaders/lib/projected.glsl"
layout(local_size_x = 32) in;  // kRunGroup

DPL_WORDS(0, OrderBlock, order);
DPL_FOURS(1, ProjectedBlock, projected);  // ProjectedSplat
layout(std430, binding = 2) buffer PlaceBlock { uint places[]; };
layout(std430, binding = 3) writeonly buffer SpanBlock { TileSpan spans[]; };
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/tiles.glsl"

void main() {
    uint run = gl_GlobalInvocationID.x, runs = places[1];
    if (run >= runs) return;
    uint end = min((run + 1u) * kRun, places[0]);
    for (uint i = run * kRun; i < end; ++i) {
        uint splat = DPL_WORD(order, i);
        for (uint v = 0u; v < kViews; ++v) {
            uint slot = v * push.splatCount + splat;
            ProjectedSplat p = dplProjected(DPL_FOUR(projected, kProjectedFours * slot), DPL_FOUR(projected, kProjectedFours * slot + 1u));
            if (dplShown(p.opacityAndRadius)) {
                SplatEllipse ellipse = dplEllipseOf(p);
                uvec2 rows = dplSplatRows(p.centrePx.y, ellipse.radiusYPx, push.heightPx);
                do {
                    uvec2 columns = dplSplatColumns(p.centrePx, ellipse, rows.x, push.widthPx);
                    uint bucket = v * push.rows + rows.x, cell = push.firstRunTable + bucket * runs + run, place = places[cell];
                    places[cell] = place + 1u;
                    spans[place] = TileSpan(slot, columns.x | columns.y << 16u);
                    ++rows.x;
                } while (rows.x <= rows.y);
            }
        }
    }
}
