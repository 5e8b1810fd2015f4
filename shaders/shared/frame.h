// SPDX-License-Identifier: Apache-2.0
// Every struct that C++ shares with shaders, or that one pass hands to the next. Members are scalars of 4 bytes and vectors of 8, 12
// and 16 bytes. A vec3 must start at a multiple of 16 bytes and be followed by a scalar, so that C++ and GLSL agree on offsets.
//
//   VertexRecord ─skin► vec4 posed (w: brightness) ─triangles► TriangleFrame ─project► ProjectedSplat (splat × view) + sort depth
//   splat codes, uints: chunk records │ parents │ place │ size │ colour │ parent bytes │ detail of groups │ SH indices │ SH entries
//                       (lib/codes.glsl)
//   visibility and survivors, uints: live groups, visible splats and their sort depths (lib/visibility.glsl)
//   sort depth ─compact► uvec2 (key, splat) ─sort► sorted splats, nearest first ─draw► pixels
//                                                                      └─tiles► spans by row of tiles ► entries by tile ─fill► pixels
//   GeneralSplatRecord ─project.general► ProjectedSplat + sort depth ─...  (general splats: no pose, no triangles)
#ifndef DPL_SHARED_FRAME_H
#define DPL_SHARED_FRAME_H
#include "shaders/shared/limits.h"
DPL_SHARED_BEGIN

struct ViewData {            // one view of the frame
    vec4 viewFromWorldRow0;  // rows of [R | t]: x right, y down, z forward, metres
    vec4 viewFromWorldRow1;
    vec4 viewFromWorldRow2;
    vec4 focalCentrePx;  // fx, fy, cx, cy
    vec4 slopeLimits;    // limits of x/z and y/z in the Jacobian: min x, max x, min y, max y
    vec3 eyeWorld;
    float pad0;
};
DPL_SHARED_SIZE(ViewData, 96)

// The only uniform block, one for each subject. The CPU writes it before each frame.
struct FrameData {
    ViewData views[2];
    vec3 sortAxis;          // unit mean forward axis of the views, in world space
    float sortStartM;       // depth along sortAxis, metres; everything that a view sees lies beyond it
    vec2 targetPx;          // width and height of one view
    float kappaPx2;         // low-pass of one coverage sample
    float splatsPerM2;      // avatars: density at rest that level of detail asks for; 0: all splats (lib/detail.glsl)
    uint compensated;       // 1: the low-pass preserves energy
    uint unseenComponents;  // bits of the components that no view sees (sdk/visibility/components.h)
    uint cullNothing;       // 1: no culling, for measurements
    uint splatCount;        // of the scene set: number of records for one view
    float largestGrowth;    // avatars: upper bound of the factor by which level of detail enlarges splats
    float shShare;          // avatars: weight of the SH bands above 0; at 0 their coefficients are not read
    float splatsPerPixel;   // general splats: density that level of detail asks for; 0: all splats
    float finestPixelM;     // general splats: lower limit of the pixel width used for level of detail, metres
    vec4 pixelPlanes[2];    // general splats, by view: width in metres of a pixel at a world point = dot(xyz, point) + w
};
DPL_SHARED_SIZE(FrameData, 288)

struct VertexRecord {  // constant, one for each vertex
    float restX, restY, restZ;
    uint joints01;  // u16 pairs
    uint joints23;
    uint weights;     // 4 x unorm8, sum 255
    uint components;  // bits of the components that use the vertex
    uint pad0;
};
DPL_SHARED_SIZE(VertexRecord, 32)

struct CorrectedVertexRecord {  // replaces VertexRecord in avatars with pose correctives
    float restX, restY, restZ;
    uint joints01;  // u16 pairs
    uint joints23;
    uint weights;  // 4 x unorm8, sum 255
    uint nodes01;  // control nodes, u16 pairs
    uint nodes23;
    uint nodeWeights;  // 4 x unorm8, sum 255
    uint components;   // bits of the components that use the vertex
    uint pad0, pad1;
};
DPL_SHARED_SIZE(CorrectedVertexRecord, 48)

struct TriangleRecord {  // constant, one for each triangle: frame and inverse edge matrix D⁻¹ at rest (docs/reference/binding.md)
    vec4 restT1;         // w: i00
    vec4 restT2;         // w: i01
    vec4 restNormal;     // w: i11
    uvec4 corners;       // vertex indices; w: number of its component, from 1; 0: degenerate at rest
    float reach;  // metres at rest: largest √level · standard deviation of its splats. With level = 2 ln(255 α), α < 1/255 beyond it
    float rootLevel;   // largest √level
    uint freeSplats;   // number of its free splats
    uint gatedSplats;  // number of its single-face splats
};
DPL_SHARED_SIZE(TriangleRecord, 80)

struct TriangleFrame {  // one for each triangle, written each frame; x, y and z are float bits, w packs smaller values
    uvec4 corner0;      // w: kShowsFree << view and kShowsGated << view: which splats may show in which view
    uvec4 corner1;      // w: x and y of the polar rotation as a quaternion, snorm16
    uvec4 corner2;      // w: z and w of the quaternion, snorm16
    uvec4 column0;      // first column of F; w: brightness at corners 0 and 1, half
    uvec4 column1;      // second column of F; w: brightness at corner 2, half
};
DPL_SHARED_SIZE(TriangleFrame, 80)

struct GeneralSplatRecord {  // constant, one for each general splat
    vec4 centre;             // world, metres; w: opacity
    vec4 axis1;              // unit axes × standard deviations, metres; w is unused
    vec4 axis2;
    vec4 axis3;
};
DPL_SHARED_SIZE(GeneralSplatRecord, 64)

struct GroupBox {  // constant: bounding box of the centres of a group of general splats
    vec4 middle;
    vec4 reach;   // half its size, metres
    vec4 detail;  // from SplatGroup: area of a splat in m², gain, enough
};
DPL_SHARED_SIZE(GroupBox, 48)

// One for each splat and view. All records of view 0 come first, so drawing one view does not read those of the other. 32 bytes are half a
// cache line; the records are read in depth order, so each read touches one line (lib/projected.glsl).
struct ProjectedSplat {
    vec4 place;  // centre in target pixels (origin top left, pixel centres at +0.5), conic A and B: σ = ½(A dx² + C dy²) + B dx dy
    // x: bits of conic C
    // y: low half: opacity after compensation, gate and near fade, unorm16; high half: half the width outside which α < 1/255,
    //    px, as a half float; 0: hidden in this view
    // z: rgb, display-referred, 11, 11 and 10 bits
    // w: bits of the view z, metres
    uvec4 look;
};
DPL_SHARED_SIZE(ProjectedSplat, 32)

struct FrameCounts {                          // written and read by the GPU; contains the arguments of its indirect commands
    uint visible;                             // records that survive culling, of all views together
    uint runs;                                // ceil(visible / kRun)
    uint trianglesInView;                     // triangles with splats that touch some view
    uint trianglesFacing;                     // of these, the ones with free splats or a front side that some view sees
    uint runGroupsX, runGroupsY, runGroupsZ;  // VkDispatchIndirectCommand over the runs
    uint chunksProjected;
    uint drawVertices, drawInstances, drawFirstVertex, drawFirstInstance;  // VkDrawIndirectCommand
    uint splatsInView;                                                     // splats of trianglesInView
    uint splatsFacing;                                                     // of these, the ones that are not turned away
    uint chunkGroupsX, chunkGroupsY, chunkGroupsZ;  // VkDispatchIndirectCommand over the groups of splats that have a splat of splatsFacing
    uint tileSpans;                                 // spans of all rows of tiles
    uint spanGroupsX, spanGroupsY, spanGroupsZ;     // VkDispatchIndirectCommand over the runs; zero when the spans do not fit
    uint tileEntries;                               // entries of all tiles
    uint rowGroupsX, rowGroupsY, rowGroupsZ;        // VkDispatchIndirectCommand over the rows of tiles; zero when the spans do not fit
    uint tilesOverflowed;                           // 1: a list was too small, so the quads draw this frame
    uint entryGroupsX, entryGroupsY, entryGroupsZ;  // VkDispatchIndirectCommand over the rows of tiles; zero when the entries do not fit
    uint fillGroupsX, fillGroupsY, fillGroupsZ;     // VkDispatchIndirectCommand over the tiles; zero when the entries do not fit
    uint depthMaxBits[16];  // by subject (kMaxDrawn): extent along the sort axis, as ordered bits (lib/order.glsl); 0: none
    uint depthMinBitsInverted[16];
    float keyStart[16];  // by subject: depth key = (depth - keyStart) * keyScale + keyOffset
    float keyOffset[16];
    float keyScale;
};
DPL_SHARED_SIZE(FrameCounts, 388)

struct TilePush {                   // shared by all tile passes; members named first... are offsets in words
    uint viewCount, columns, rows;  // columns and rows: tiles of one view
    uint widthPx, heightPx;         // of one view
    uint firstSpanSum;              // in the sums: spans before each share of a row of tiles (views × rows × kRowScanGroup + 1 words)
    uint firstEntrySum;             // the same for entries
    uint firstRunTable;             // in the table and in the places: [row][run], the number of spans and where the next one goes
    uint firstTileTable;            // the same for entries: [row][column][segment]
    uint spanCapacity, entryCapacity;
    uint fillGroups;
    uint firstDepth;  // in the pixel buffer: depth sums
    uint halfDepth;
    uint firstScene;  // in the pixel buffer: view z of the app's scene, infinite where it is empty
    uint splatCount;  // of the scene set: number of records for one view
    uint tileShift;   // a tile is 1 << tileShift pixels across and down
    float reachPx;    // largest distance of a coverage sample from the pixel centre, along x or y
};
struct RowScanPush {
    uint perRow;      // cells of a row; 0: counts.runs
    uint firstTable;  // in the table and in the places
    uint firstSum;
};

// The subjects of a frame share its lists. `drawn` is the number of a subject in its scene set; firstGroup and firstSplat are the numbers
// of groups and splats of the subjects before it.
struct VertexPush {
    uint vertexCount;
    uint firstNode;  // in the palette: the control nodes follow the rows of the joints
    uint drawn;
};
struct TrianglePush {
    uint triangleCount;
};
struct MeshDepthPush {
    uint triangleCount;
    uint viewCount;
    uint widthPx;  // of one view
    uint heightPx;
};
struct SplatPush {
    uint splatCount;
    uint allGroups;
    uint firstGroup;
    uint firstSplat;
    uint drawn;
};
// Where the streams of an avatar's splat codes begin, in words. firstShIndex 0: each splat has its own SH entry of shWords words.
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
struct ColourPush {  // for general splats
    uint splatCount;
    uint firstSplat;
};
struct CompactPush {
    uint groupCount;
    uint maxDepthKey;
    uint drawnCount;
    uint endGroup[16];  // by subject (kMaxDrawn): one past its last group
};
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
    uint splatCount;  // of the scene set
    uint view;        // read only without multiview
};

DPL_SHARED_END
#endif
