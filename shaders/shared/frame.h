// SPDX-License-Identifier: Apache-2.0
// Every struct that crosses from C++ to a shader or from one pass to the next. Scalars of four bytes and vectors of 8, 12 and 16 bytes
// only; a vec3 lies at a multiple of 16 with a scalar behind it, so that both languages agree.
//
//   VertexRecord ─skin► vec4 posed (w: brightness) ─triangles► TriangleFrame ─project► ProjectedSplat (splat × view) + sort depth
//   splat codes, uints: chunk records │ parents │ place │ size │ colour │ parent bytes │ detail of groups │ SH indices │ SH entries
//                       (lib/codes.glsl)
//   visibility and survivors, uints: which groups live, which of their splats show, and their sort depths (lib/visibility.glsl)
//   sort depth ─compact► uvec2 (key, splat) ─sort► splats, near first ─draw► pixels
//                                                                      └─tiles► spans by row of tiles ► entries by tile ─fill► pixels
//   GeneralSplatRecord ─project.general► the same two ─...  (general splats: no pose, no triangles)
#ifndef DPL_SHARED_FRAME_H
#define DPL_SHARED_FRAME_H
#include "shaders/shared/limits.h"
DPL_SHARED_BEGIN

struct ViewData {            // one eye of the frame
    vec4 viewFromWorldRow0;  // rows of [R | t]: x right, y down, z forward, metres
    vec4 viewFromWorldRow1;
    vec4 viewFromWorldRow2;
    vec4 focalCentrePx;  // fx, fy, cx, cy
    vec4 slopeLimits;    // x/z and y/z limits of the Jacobian: min x, max x, min y, max y
    vec3 eyeWorld;
    float pad0;
};
DPL_SHARED_SIZE(ViewData, 96)

// The only uniform block, one for each subject; written by the CPU before each frame.
struct FrameData {
    ViewData views[2];
    vec3 sortAxis;          // unit mean forward axis of the views, world
    float sortStartM;       // depth along it before which no view sees anything
    vec2 targetPx;          // size of a view
    float kappaPx2;         // low-pass of a sample
    float splatsPerM2;      // avatars: density that level of detail wants, at rest; 0: all splats (lib/detail.glsl)
    uint compensated;       // 1: the low-pass keeps energy
    uint unseenComponents;  // bits of the components that no view sees (sdk/visibility/components.h)
    uint cullNothing;       // 1: for measuring
    uint splatCount;        // of the scene set: records of one view
    float largestGrowth;    // avatars: of a splat's scales at this level of detail
    float shShare;          // avatars: of the SH bands beyond coefficient 0
    float splatsPerPixel;   // general splats: density that level of detail wants; 0: all splats
    float finestPixelM;     // general splats: no pixel counts as smaller
    vec4 pixelPlanes[2];    // general splats: a pixel at a point is dot(xyz, point) + w metres wide; one for each eye of the draw
};
DPL_SHARED_SIZE(FrameData, 288)

struct VertexRecord {  // static, per vertex
    float restX, restY, restZ;
    uint joints01;  // u16 pairs
    uint joints23;
    uint weights;     // 4 x unorm8, sum 255
    uint components;  // bits of those that use it
    uint pad0;
};
DPL_SHARED_SIZE(VertexRecord, 32)

struct CorrectedVertexRecord {  // instead of VertexRecord in avatars with pose correctives
    float restX, restY, restZ;
    uint joints01;  // u16 pairs
    uint joints23;
    uint weights;  // 4 x unorm8, sum 255
    uint nodes01;  // control nodes, u16 pairs
    uint nodes23;
    uint nodeWeights;  // 4 x unorm8, sum 255
    uint components;   // bits of those that use it
    uint pad0, pad1;
};
DPL_SHARED_SIZE(CorrectedVertexRecord, 48)

struct TriangleRecord {  // static, per triangle; frame and D⁻¹ of the rest triangle (binding.h)
    vec4 restT1;         // w: i00
    vec4 restT2;         // w: i01
    vec4 restNormal;     // w: i11
    uvec4 corners;       // vertex indices; w: 0 = not valid at rest, else the number of its component, from 1
    float
        reach;  // largest √level · standard deviation of its splats, metres at rest; level = 2 ln(255 α): farther out they are below 1/255
    float rootLevel;   // largest √level
    uint freeSplats;   // that show both faces
    uint gatedSplats;  // that show one
};
DPL_SHARED_SIZE(TriangleRecord, 80)

struct TriangleFrame {  // per triangle and frame; bits of floats but for w, which packs what needs less
    uvec4 corner0;      // w: kShowsFree << view, kShowsGated << view: which of its splats which view may show
    uvec4 corner1;      // w: polar rotation, quaternion x and y, snorm16
    uvec4 corner2;      // w: z and w
    uvec4 column0;      // of F; w: brightness at corners 0 and 1, half
    uvec4 column1;      // w: at corner 2
};
DPL_SHARED_SIZE(TriangleFrame, 80)

struct GeneralSplatRecord {  // static, per general splat
    vec4 centre;             // world; w: opacity
    vec4 axis1;              // unit axes × standard deviations, metres; w unused
    vec4 axis2;
    vec4 axis3;
};
DPL_SHARED_SIZE(GeneralSplatRecord, 64)

struct GroupBox {  // static, about the centres of kSplatGroup general splats
    vec4 middle;
    vec4 reach;   // half its size
    vec4 detail;  // SplatGroup: area of a splat, m², gain, enough
};
DPL_SHARED_SIZE(GroupBox, 48)

struct ProjectedSplat {  // per splat and view, one view behind the other: who draws one reads no memory of the other. Half a cache line:
                         // they are read in the order of depth (lib/projected.glsl)
    vec4 place;          // centre in target pixels (origin top left, centres at +0.5), conic A and B: σ = ½(A dx² + C dy²) + B dx dy
    uvec4 look;  // bits of conic C; opacity after compensation, gate and near fade, unorm16, with half the width outside which α < 1/255,
                 // px, half: 0 = not in this view; rgb display-referred, 11, 11 and 10 bits; bits of view z, metres
};
DPL_SHARED_SIZE(ProjectedSplat, 32)

struct FrameCounts {                          // written by the GPU for itself; the indirect arguments live inside
    uint visible;                             // survivors of culling, all views together
    uint runs;                                // ceil(visible / kRun)
    uint trianglesInView;                     // that carry splats and touch some view
    uint trianglesFacing;                     // of these, with splats that are not all turned away
    uint runGroupsX, runGroupsY, runGroupsZ;  // VkDispatchIndirectCommand over the runs
    uint chunksProjected;
    uint drawVertices, drawInstances, drawFirstVertex, drawFirstInstance;  // VkDrawIndirectCommand
    uint splatsInView;                                                     // on trianglesInView
    uint splatsFacing;                                                     // of these, not turned away
    uint chunkGroupsX, chunkGroupsY, chunkGroupsZ;  // VkDispatchIndirectCommand over the chunks that have such a splat
    uint tileSpans;                                 // of all rows of tiles
    uint spanGroupsX, spanGroupsY, spanGroupsZ;     // the same over the runs, and over the rows: zero when the spans do not fit
    uint tileEntries;                               // of all tiles
    uint rowGroupsX, rowGroupsY, rowGroupsZ;
    uint tilesOverflowed;                           // 1: a list was too small, the quads draw this frame
    uint entryGroupsX, entryGroupsY, entryGroupsZ;  // over the rows, and over the tiles: zero when the entries do not fit
    uint fillGroupsX, fillGroupsY, fillGroupsZ;
    uint depthMaxBits[16];  // kMaxDrawn: posed bounds of each along the sort axis, order-preserving float bits (lib/order.glsl); 0: nothing
    uint depthMinBitsInverted[16];
    float keyStart[16];  // depth key = (depth - keyStart) * keyScale + keyOffset
    float keyOffset[16];
    float keyScale;
};
DPL_SHARED_SIZE(FrameCounts, 388)

struct TilePush {                   // of every tile pass; `first...`: offsets in words
    uint viewCount, columns, rows;  // tiles across and down one view
    uint widthPx, heightPx;         // of one view
    uint firstSpanSum;              // into the sums: spans before each share of a row of tiles (views × rows × kRowScanGroup + 1)
    uint firstEntrySum;             // the same of entries
    uint firstRunTable;             // into the table and the places: [row][run], spans and where the next one goes
    uint firstTileTable;            // [row][column][segment], entries and where the next one goes
    uint spanCapacity, entryCapacity;
    uint fillGroups;
    uint firstDepth;  // in the pixel buffer, words
    uint halfDepth;
    uint firstScene;  // in the pixel buffer, words: the app's depth, infinite where there is nothing
    uint splatCount;  // of all that is drawn: records of a view
    uint tileShift;   // a tile is 1 << tileShift pixels across and down
    float reachPx;    // of a pixel's samples from its centre, along x or y
};
struct RowScanPush {
    uint perRow;
    uint firstTable;
    uint firstSum;
};  // perRow 0: counts.runs; firstTable: in table and places

// Several avatars share a frame: `drawn` is the number of one, its groups and splats come behind those of the ones before it.
struct VertexPush {
    uint vertexCount;
    uint firstNode;
    uint drawn;
};  // control nodes in the palette, behind the joints' rows
struct TrianglePush {
    uint triangleCount;
};
struct MeshDepthPush {
    uint triangleCount;
    uint viewCount;
    uint widthPx;
    uint heightPx;
};  // of one view
struct SplatPush {
    uint splatCount;
    uint allGroups;
    uint firstGroup;
    uint firstSplat;
    uint drawn;
};
// Where the streams of an avatar's splat codes begin, in words; firstShIndex 0: every splat has its own SH entry, of shWords.
struct CodesPush {
    uint groupCount;
    uint allGroups;
    uint firstGroup;
    uint firstSplat;
    uint firstParent;
    uint firstPlace;
    uint firstSize;
    uint firstColour;
    uint firstParentByte;
    uint firstGroupDetail;
    uint firstShIndex;
    uint firstSh;
    uint shWords;
};
struct ChunkPush {
    uint groupCount;
    uint allGroups;
    uint firstGroup;
};
struct ColourPush {
    uint splatCount;
    uint firstSplat;
};  // of general splats
struct CompactPush {
    uint groupCount;
    uint maxDepthKey;
    uint drawnCount;
    uint endGroup[16];
};  // kMaxDrawn: where the groups of each end
struct MaskPush {
    uint groupCount;
};
struct ScanPush {
    uint first;
    uint count;
};
struct ArgsPush {
    uint groupCount;
    uint maxDepthKey;
    uint drawnCount;
};
struct SortPush {
    uint shift;
};
struct DrawPush {
    float targetWidthPx;
    float targetHeightPx;
    uint splatCount;
    uint view;
};  // splatCount: of all that is drawn; view: without multiview

DPL_SHARED_END
#endif
