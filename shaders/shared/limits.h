// SPDX-License-Identifier: Apache-2.0
// Work sizes and code layouts that C++ and GLSL share. Constants of the formulas are in sdk/math/formulas/constants.h. The splat codes
// and the limits of brightness repeat values of sdk/format and sdk/avatar/pose_correctives.h; sdk/render/avatar_upload.cpp asserts that
// they agree.
#ifndef DPL_SHARED_LIMITS_H
#define DPL_SHARED_LIMITS_H
#include "shaders/shared/shim.h"
DPL_SHARED_BEGIN

DPL_CONST uint kMaxViews = 2u;
DPL_CONST uint kMaxDrawn = 16u;  // subjects in one frame

// Workgroup sizes, unless a comment says otherwise. No kernel assumes a subgroup width: scans go through shared memory.
DPL_CONST uint kVertexGroup = 128u;
DPL_CONST uint kSplatGroup = 128u;
DPL_CONST uint kChunkGroup = 64u;  // groups of splats
DPL_CONST uint kScanGroup = 256u;
DPL_CONST uint kSceneGroup = 64u;  // pixels of a row
DPL_CONST uint kFillGroup = 256u;
DPL_CONST uint kFillWords = 4096u;   // that a workgroup fills
DPL_CONST uint kRowScanGroup = 16u;  // shares that a row of a table is divided into
DPL_CONST uint kCompactGroup = 64u;
DPL_CONST uint kUnseenDepth = 0xFFFFFFFFu;  // sort depth of a splat that no view shows: a NaN, so no real depth equals it
DPL_CONST uint kMaskWords = 4u;             // one bit for each splat of a group: set if some view shows it

// Sorting and the lists of tiles. A workgroup works through a run of kRun neighbouring entries, kRunGroup at a time.
DPL_CONST uint kRun = 256u;
DPL_CONST uint kRunGroup = 32u;  // the bits of a word
DPL_CONST uint kSortDigitBits = 8u;
DPL_CONST uint kSortDigits = 256u;
DPL_CONST uint kSortIndexBits = 24u;  // bits of a splat number; a digit of the key fits into the bits above it
DPL_CONST uint kSortRounds = 2u;      // 16-bit keys: 0.03 mm steps across a person
DPL_CONST uint kWideSortRounds = 3u;  // 24-bit keys: a scene of general splats may reach a kilometre

// Splat codes (sdk/format/coded_splats.h): word offsets in the record of a chunk, and constants that decode the words of a splat.
DPL_CONST uint kChunkWords = 16u;
DPL_CONST uint kChunkScaleMin = 4u;
DPL_CONST uint kChunkScaleMax = 5u;
DPL_CONST uint kChunkDcMin = 6u;     // three words
DPL_CONST uint kChunkDcMax = 9u;     // three words
DPL_CONST uint kChunkShRange = 12u;  // three words
DPL_CONST uint kChunkFirstParent = 15u;
DPL_CONST uint kGatedBit = 0x40000000u;  // in the size word: the splat is single-face
DPL_CONST float kUvZeroCode = 113.0;
DPL_CONST float kUvCodeSteps = 1820.0;
DPL_CONST float kPhiCodeStep = 0.0030679615757712823;  // π / 1024

// Compute tiles. A lane owns one column of a tile.
DPL_CONST uint kTilePxShift = 3u;      // one sample a pixel: a tile is 8 × 8 pixels
DPL_CONST uint kFourTilePxShift = 2u;  // four samples a pixel: 4 × 4 pixels, so a tile has 64 samples either way
DPL_CONST uint kTileGroup = 64u;       // of the fill kernel: 8 tiles, or 16 at four samples
DPL_CONST uint kTileSegments = 4u;     // parts of the spans of a row, listed by a workgroup each
DPL_CONST uint kMostTiles = 1024u;     // rows or columns of tiles in a view
DPL_CONST float kTileStop = 1e-4;      // transmittance below which a pixel is done: 0.03 levels

DPL_CONST uint kMeshDepthOwnPixels = 64u;  // a triangle with a larger bounding box is shared by all lanes of the workgroup

DPL_CONST float kDepthCoverage = 0.5;  // least alpha of a pixel of the picture that writes depth into an app's image

DPL_CONST uint kShowsFree = 1u;             // in TriangleFrame.shows, shifted left by the view: free splats may show
DPL_CONST uint kShowsGated = 4u;            // the same for single-face splats
DPL_CONST uint kParentFree = 0x40000000u;   // in an entry of the table of parents: the chunk has free splats on this triangle
DPL_CONST uint kParentGated = 0x80000000u;  // the same for single-face splats
DPL_CONST uint kParentMask = 0x3FFFFFFFu;   // number of the triangle

// Splats in an app's buffer. Properties: DplSplatProperty of doppel_posed.h; sdk/api/write_on_gpu.cpp asserts that they agree.
DPL_CONST uint kWrittenElements = 16u;   // most in one buffer
DPL_CONST uint kShTurnDirections = 15u;  // 2l + 1 for each band l
DPL_CONST uint kShTurnRows = 21u;        // vec4s with the 9 + 25 + 49 numbers of P⁻¹ (sdk/math/sh_rotation.h)
DPL_CONST uint kWritePosition = 0u;
DPL_CONST uint kWriteRotation = 1u;
DPL_CONST uint kWriteScale = 2u;
DPL_CONST uint kWriteCovariance = 3u;
DPL_CONST uint kWriteOpacity = 4u;
DPL_CONST uint kWriteColour = 5u;
DPL_CONST uint kWriteSh = 6u;
DPL_CONST uint kWriteRotationWxyz = 7u;

DPL_CONST float kGpuMinLight = 0.2;
DPL_CONST float kGpuMaxLight = 3.0;

DPL_SHARED_END
#endif
