// SPDX-License-Identifier: Apache-2.0
// Work sizes and code layouts that C++ and GLSL share. Numbers of the formulas are in sdk/math/formulas/constants.h. Codes and
// brightness repeat sdk/format and sdk/avatar/pose_correctives.h; sdk/render/avatar_upload.cpp asserts that they agree.
#ifndef DPL_SHARED_LIMITS_H
#define DPL_SHARED_LIMITS_H
#include "shaders/shared/shim.h"
DPL_SHARED_BEGIN

DPL_CONST uint kMaxViews = 2u;
DPL_CONST uint kMaxDrawn = 16u;  // avatars and sets of general splats in one frame

// Group sizes. No kernel assumes a subgroup width: scans go through shared memory.
DPL_CONST uint kVertexGroup = 128u;
DPL_CONST uint kSplatGroup = 128u;
DPL_CONST uint kChunkGroup = 64u;  // half-chunks
DPL_CONST uint kScanGroup = 256u;
DPL_CONST uint kRowScanGroup = 16u;  // shares of a row of a table
DPL_CONST uint kCompactGroup = 64u;
DPL_CONST uint kUnseenDepth = 0xFFFFFFFFu;  // no float of a splat: NaN
DPL_CONST uint kMaskWords = 4u;             // kSplatGroup bits: which splats of a half-chunk some view shows

// Sorting, and the lists of tiles: a lane works through a run of neighbours by itself, so order needs neither atomics nor barriers.
DPL_CONST uint kRun = 256u;
DPL_CONST uint kRunGroup = 32u;
DPL_CONST uint kSortDigitBits = 8u;
DPL_CONST uint kSortDigits = 256u;
DPL_CONST uint kSortIndexBits = 24u;   // of the number of a splat: a digit fits above
DPL_CONST uint kSortRounds = 2u;       // 16-bit keys: 0.03 mm steps across a person
DPL_CONST uint kWideSortRounds = 3u;   // 24-bit keys: a scene of general splats may reach a kilometre
DPL_CONST uint kFloatSortRounds = 4u;  // 32-bit float keys, for measuring
DPL_CONST uint kFloatDepthKeys = 0u;   // the largest key of float keys: none

// Splat codes (sdk/format/coded_splats.h): words of a chunk's record, and what the fields of a splat's words mean.
DPL_CONST uint kChunkWords = 16u;
DPL_CONST uint kChunkScaleMin = 4u;
DPL_CONST uint kChunkScaleMax = 5u;
DPL_CONST uint kChunkDcMin = 6u;  // three each
DPL_CONST uint kChunkDcMax = 9u;
DPL_CONST uint kChunkShRange = 12u;  // three
DPL_CONST uint kChunkFirstParent = 15u;
DPL_CONST uint kGatedBit = 0x40000000u;  // of the size word: shows one face
DPL_CONST float kUvZeroCode = 113.0;
DPL_CONST float kUvCodeSteps = 1820.0;
DPL_CONST float kPhiCodeStep = 0.0030679615757712823;  // π / 1024

// Compute tiles. A lane owns one column of a tile.
DPL_CONST uint kTilePxShift = 3u;      // 8 pixels of one sample each
DPL_CONST uint kFourTilePxShift = 2u;  // 4 pixels of four: a tile is 64 samples either way
DPL_CONST uint kTileGroup = 64u;       // of the raster pass: 8 tiles, or 16
DPL_CONST uint kTileSegments = 4u;     // lanes that share a row of tiles
DPL_CONST float kTileStop = 1e-4;      // transmittance at which a pixel is done: 0.03 levels

DPL_CONST uint kMeshDepthOwnPixels = 64u;  // a larger box is shared by the lanes of a group

DPL_CONST uint kShowsFree = 1u;  // TriangleFrame.corner0.w, shifted by the view
DPL_CONST uint kShowsGated = 4u;
DPL_CONST uint kParentFree = 0x40000000u;  // of an entry of the table of parents: the chunk has such splats on it
DPL_CONST uint kParentGated = 0x80000000u;
DPL_CONST uint kParentMask = 0x3FFFFFFFu;

DPL_CONST float kGpuMinLight = 0.2;
DPL_CONST float kGpuMaxLight = 3.0;

DPL_SHARED_END
#endif
