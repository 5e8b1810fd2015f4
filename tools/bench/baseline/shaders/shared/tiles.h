// SPDX-License-Identifier: Apache-2.0
// Frozen (tests/baseline/README.md). The first way to fill pixels by compute tiles: its structs and sizes.
//
//   sorted splats ─runs, scan, spans► (record, columns) by row of tiles ─count, scan, entries► records by tile ─fill► pixels
#ifndef DPL_PLAIN_TILES_H
#define DPL_PLAIN_TILES_H
#include "tools/bench/baseline/shaders/shared/frame.h"
DPL_PLAIN_BEGIN

DPL_PLAIN_CONST uint kTilePx = 8u;          // a lane owns one column of a tile
DPL_PLAIN_CONST uint kTileGroup = 64u;      // of the raster pass: 8 tiles
DPL_PLAIN_CONST uint kTileListGroup = 32u;  // of the passes that make the lists, where each lane works through a run by itself
DPL_PLAIN_CONST uint kTileScanGroup = 64u;
DPL_PLAIN_CONST uint kTileRun = 256u;     // sorted splats a lane
DPL_PLAIN_CONST uint kTileSegments = 4u;  // lanes that share a row of tiles
DPL_PLAIN_CONST float kTileStop = 1e-4;   // transmittance at which a pixel is done: 0.03 levels

struct TileCounts {   // written by the GPU for itself
    uint spans;       // of all rows of tiles
    uint entries;     // of all tiles
    uint overflowed;  // 1: a list was too small, nothing was drawn
    uint pad0;
    uint spanGroupsX, spanGroupsY, spanGroupsZ;  // VkDispatchIndirectCommand over the runs; zero when the spans do not fit, as are the next
    uint pad1;
    uint rowGroupsX, rowGroupsY, rowGroupsZ;  // over the rows
    uint pad2;
    uint entryGroupsX, entryGroupsY, entryGroupsZ;  // over the rows and over the tiles: zero when the entries do not fit
    uint pad3;
    uint fillGroupsX, fillGroupsY, fillGroupsZ;
    uint pad4;
};
DPL_PLAIN_SIZE(TileCounts, 80)

struct TilePush {        // of every tile pass; `first...`: offsets into the tile lists, one buffer of uints
    uint columns, rows;  // tiles across and down
    uint widthPx, heightPx;
    uint firstSpanSum;    // spans before each row of tiles (rows + 1)
    uint firstEntrySum;   // entries before each row of tiles
    uint firstRunTable;   // [row][run]: spans, then where the next one goes
    uint firstTileTable;  // [row][column][segment]: entries within the row, then where the next one goes
    uint firstSpan;       // (record, first column | last column << 16)
    uint spanCapacity, entryCapacity;
    uint fillGroups;
};
struct TileScanPush {
    uint perRow;
    uint firstTable;
    uint firstSum;
};  // perRow 0: the runs
struct TileSumPush {
    uint first;
    uint count;
};

DPL_PLAIN_END
#endif
