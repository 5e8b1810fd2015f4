// SPDX-License-Identifier: Apache-2.0
// Frozen (tests/baseline/README.md). Every struct that crosses from C++ to a shader or from one pass to the next. Four-byte scalars and
// 8/16-byte vectors only.
//
//   VertexRecord ─skin► vec4 posed (w: brightness) ─triangles► TriangleFrame ─project► ProjectedSplat (splat × view) + sort depth
//                                                            └─colour► ProjectedSplat.colour
//   sort depth ─compact► uvec2 (key, splat) ─sort► the same, near first ─draw► pixels
#ifndef DPL_PLAIN_FRAME_H
#define DPL_PLAIN_FRAME_H
#include "tools/bench/baseline/shaders/shared/limits.h"
DPL_PLAIN_BEGIN

struct ViewData {            // one eye of the frame
    vec4 viewFromWorldRow0;  // rows of [R | t]: x right, y down, z forward, metres
    vec4 viewFromWorldRow1;
    vec4 viewFromWorldRow2;
    vec4 focalCentrePx;  // fx, fy, cx, cy
    vec4 slopeLimits;    // x/z and y/z limits of the Jacobian: min x, max x, min y, max y
    vec4 eyeWorld;       // xyz
};
DPL_PLAIN_SIZE(ViewData, 96)

struct FrameData {  // the only uniform block; written by the CPU before each frame
    ViewData views[2];
    vec4 sortAxis;  // unit mean forward axis of the views, world
    vec4 target;    // width px, height px, kappa px², 0
    uvec4 counts;   // splats, views, SH degree, 1 = energy-preserving low-pass
};
DPL_PLAIN_SIZE(FrameData, 240)

struct VertexRecord {  // static, per vertex
    float restX, restY, restZ;
    uint joints01;  // u16 pairs
    uint joints23;
    uint weights;  // 4 x unorm8, sum 255
    uint pad0, pad1;
};
DPL_PLAIN_SIZE(VertexRecord, 32)

struct CorrectedVertexRecord {  // instead of VertexRecord in avatars with pose correctives
    float restX, restY, restZ;
    uint joints01;  // u16 pairs
    uint joints23;
    uint weights;  // 4 x unorm8, sum 255
    uint nodes01;  // control nodes, u16 pairs
    uint nodes23;
    uint nodeWeights;  // 4 x unorm8, sum 255
    uint pad0, pad1, pad2;
};
DPL_PLAIN_SIZE(CorrectedVertexRecord, 48)

struct TriangleRecord {  // static, per triangle; frame and D⁻¹ of the rest triangle (binding.h)
    vec4 restT1;         // w: i00
    vec4 restT2;         // w: i01
    vec4 restNormal;     // w: i11
    uvec4 corners;       // vertex indices; w: 1 = valid at rest
};
DPL_PLAIN_SIZE(TriangleRecord, 64)

struct TriangleFrame {    // per triangle and frame; w components carry the valid flag, the unit normal and brightness
    vec4 v0;              // w: 1 = draw its splats
    vec4 v1;              // w: normal x
    vec4 v2;              // w: normal y
    vec4 f0;              // first column of F; w: normal z
    vec4 f1;              // second column of F
    vec4 worldFromRest0;  // columns of the polar rotation; w: brightness at corner 0
    vec4 worldFromRest1;  // w: at corner 1
    vec4 worldFromRest2;  // w: at corner 2
};
DPL_PLAIN_SIZE(TriangleFrame, 128)

struct SplatRecord {     // static, per splat
    vec2 uv;             // barycentric of corners 1 and 2
    float s1Cos, s1Sin;  // s1 (cos φ, sin φ): A1 =  s1Cos F0 + s1Sin F1, metres
    float s2Cos, s2Sin;  // s2 (cos φ, sin φ): A2 = -s2Sin F0 + s2Cos F1
    float opacity;       // linear
    uint triangleAndFlags;
};
DPL_PLAIN_SIZE(SplatRecord, 32)

struct GeneralSplatRecord {  // static, per general splat
    vec4 centre;             // world; w: opacity
    vec4 axis1;              // unit axes × standard deviations, metres; w unused
    vec4 axis2;
    vec4 axis3;
};
DPL_PLAIN_SIZE(GeneralSplatRecord, 64)

struct ProjectedSplat {            // per splat and view, index splat * views + view; opacity 0 = not in this view
    vec2 centrePx;                 // target pixels, origin top left, centres at +0.5
    vec2 radiusPx;                 // half box outside which α < 1/255
    float conicA, conicB, conicC;  // σ = ½(A dx² + C dy²) + B dx dy
    float opacity;                 // after compensation, gate and near fade
    vec4 colour;                   // rgb display-referred; w: view z, metres
};
DPL_PLAIN_SIZE(ProjectedSplat, 48)

struct FrameCounts {  // written by the GPU for itself; the indirect arguments live inside
    uint visible;     // survivors of culling, all views together
    uint sortBlocks;  // ceil(visible / kSortBlock)
    uint pad0, pad1;
    uint sortGroupsX, sortGroupsY, sortGroupsZ;  // VkDispatchIndirectCommand
    uint pad2;
    uint drawVertices, drawInstances, drawFirstVertex, drawFirstInstance;  // VkDrawIndirectCommand
    uint pad3, pad4, pad5, pad6;
};
DPL_PLAIN_SIZE(FrameCounts, 64)

struct VertexPush {
    uint vertexCount;
    uint firstNode;
};  // control nodes in the palette, behind the joints' rows
struct TrianglePush {
    uint triangleCount;
};
struct SplatPush {
    uint splatCount;
    uint viewCount;
};
struct ColourPush {
    uint splatCount;
    uint viewCount;
    uint shDegree;
    uint shStride;
};  // stride in floats per splat
struct CompactPush {
    uint splatCount;
    uint blockCount;
};
struct ScanPush {
    uint count;
    uint fromSort;
};  // fromSort 1: kSortDigits * sortBlocks entries, else `count`
struct ArgsPush {
    uint blockCount;
    uint instancesPerSplat;
};
struct SortPush {
    uint shift;
};
struct DrawPush {
    float targetWidthPx;
    float targetHeightPx;
    uint viewCount;
    uint atlasColumns;
};

DPL_PLAIN_END
#endif
