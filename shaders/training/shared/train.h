// SPDX-License-Identifier: Apache-2.0
// What the kernels of a training step and reconstruction/training/gpu share. Buffers, in the order of a step:
//
//   TrainRestTriangle, TrainRestInverse, posed vertices ─frames► TrainTriangle
//   TrainSplat, sh, TrainTriangle ─project► TrainScreen, ForwardRecord, pairs (depth, splat)
//     ─sort► splats, nearest first ─count, scan, entries► pairs (tile, place of the entry by splat) ─sort, ranges► entries by tile
//     ─blend► pixels ─loss, ssim► gradient of each pixel ─pixels► TrainEntrySums by splat ─splats► gradient rows, TrainTriangleGradient
//     ─triangles► gradients of corners ─vertices► gradients of posed vertices
//     gradient rows ─adam► rows, TrainSplat, sh
#ifndef DPL_SHARED_TRAIN_H
#define DPL_SHARED_TRAIN_H
#include "shaders/shared/shim.h"
DPL_SHARED_BEGIN

DPL_CONST uint kTrainTilePx = 16u;
DPL_CONST uint kTrainTilePixels = 256u;     // also the workgroup of blend and pixels
DPL_CONST uint kTrainGroup = 128u;          // workgroup of all other kernels, unless they say otherwise
DPL_CONST uint kTrainScanCells = 256u;      // cells of a row of the scanned table of entries by splat
DPL_CONST uint kTrainBatch = 64u;           // entries that a tile loads at a time
DPL_CONST uint kTrainEntriesWord = 21u;     // of FrameCounts.tileEntries
DPL_CONST uint kTrainHidden = 0xFFFFFFFFu;  // depth of a splat that is not drawn: no float is as large
DPL_CONST uint kTrainSingleFace = 1u;       // TrainSplat.flags
DPL_CONST uint kTrainCloth = 2u;
DPL_CONST uint kTrainValid = 1u;  // TrainTriangle.flags
DPL_CONST uint kTrainBounded = 2u;
DPL_CONST uint kTrainPictureWords = 3u;   // of a pixel: (r, g, b, mask), (cloth, shown, unsure, -), (r, g, b, -) of what lies behind
DPL_CONST uint kTrainSums = 6u;           // of a workgroup of loss: L1, mask, cloth, squared error, its count, SSIM
DPL_CONST uint kTrainTriangleFours = 6u;  // of a splat's part of the gradients of its triangle

// Of TrainableSplats and AdamRows; reconstruction/training/gpu/gpu_engine.cpp asserts that they agree.
DPL_CONST float kTrainMinLogScale = -9.0;
DPL_CONST float kTrainMaxLogScale = -2.3;
DPL_CONST float kTrainMaxLogit = 8.0;
DPL_CONST float kTrainMaxSizeRatio = 0.6;
DPL_CONST float kTrainLogAnisotropy = 2.30258509;
DPL_CONST float kTrainBeta1 = 0.9;
DPL_CONST float kTrainBeta2 = 0.999;
DPL_CONST uint kTrainLastCorrection = 20001u;

struct TrainFrame {
    vec4 viewFromWorldRow0;  // rows of [R | t]
    vec4 viewFromWorldRow1;
    vec4 viewFromWorldRow2;
    vec4 eye;         // world
    vec4 background;  // colour behind the person
    vec2 focalPx;
    vec2 centrePx;
    vec2 minSlope;  // limits of x/z and y/z in the Jacobian
    vec2 maxSlope;
    float kappaPx2;
    uint widthPx;
    uint heightPx;
    uint columns;  // tiles
    uint tiles;
    uint splatCount;
    uint triangleCount;
    uint vertexCount;
    uint shDegree;
    uint shFloats;  // of a splat
    uint rowFloats;
    uint entryCapacity;
    float l1Step;  // weight over the number of terms
    float maskStep;
    float clothStep;  // 0: the picture is compared without the cloth label
    float ssimStep;
    float edgeMaskWeight;
    uint hasShown;  // the target has `shown`, `unsure` and what lies behind
    uint hasUnsure;
    uint updates;        // 0: splats stay as they are
    uint countsDensity;  // the picture counts towards density control
    float halfHeight;
    float sizeTerm;  // weights of the terms on a splat's size, over the number of splats
    float anisotropyTerm;
};
DPL_SHARED_SIZE(TrainFrame, 208)

struct TrainSplat {  // linear values
    float u;
    float v;
    float phi;
    float opacity;
    float scale1M;
    float scale2M;
    uint flags;
    uint triangle;
};
DPL_SHARED_SIZE(TrainSplat, 32)

struct TrainTriangle {  // TriangleFrame<float>
    float v0X, v0Y, v0Z, shown;
    float v1X, v1Y, v1Z;
    uint flags;
    float v2X, v2Y, v2Z, light0;
    float f0X, f0Y, f0Z, light1;
    float f1X, f1Y, f1Z, light2;
    float normalX, normalY, normalZ, pad0;
    float restX0, restX1, restX2, pad1;  // columns of worldFromRest
    float restY0, restY1, restY2, pad2;
    float restZ0, restZ1, restZ2, pad3;
};
DPL_SHARED_SIZE(TrainTriangle, 144)

struct TrainRestTriangle {  // RestTriangle<float> that splat sizes refer to, and the vertices at its corners
    float i00, i01, i11;    // D⁻¹ = [i00 i01; 0 i11]
    uint valid;
    float t1X, t1Y, t1Z;
    uint corner0;
    float t2X, t2Y, t2Z;
    uint corner1;
    float normalX, normalY, normalZ;
    uint corner2;
};
DPL_SHARED_SIZE(TrainRestTriangle, 64)

struct TrainRestInverse {  // of the triangle that stretch is measured from
    float i00, i01, i11;
};
DPL_SHARED_SIZE(TrainRestInverse, 12)

struct TrainTriangleConstants {
    float floorM;      // in-plane size floor
    float referenceM;  // size that splats are compared with
    uint learns;       // 0: its splats stay as they started
    uint pad0;
};
DPL_SHARED_SIZE(TrainTriangleConstants, 16)

struct TrainScreen {  // a projected splat; opacity 0: not drawn
    float x, y, conicA, conicB;
    float conicC, opacity, red, green;
    float blue, radiusX, radiusY, inverseVarianceY;
    float cloth;
    uint firstTile;  // column, and row in the high half
    uint lastTile;
    uint tileCount;  // 0: not drawn
};
DPL_SHARED_SIZE(TrainScreen, 64)

struct TrainEntrySums {  // EntrySums of the trainer
    float s, sx, sy, sxx;
    float sxy, syy, red, green;
    float blue, weight, pad0, pad1;
};
DPL_SHARED_SIZE(TrainEntrySums, 48)

DPL_SHARED_END
#endif
