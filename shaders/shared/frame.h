// SPDX-License-Identifier: Apache-2.0
// Every struct that C++ shares with shaders, or that one pass hands to the next. Members are scalars of 4 bytes and vectors of 8 and 16
// bytes. No member is a vec3, because GLSL and C++ align it differently: X, Y and Z are scalars. kNameFours: uvec4s of a record, for
// kernels that read it by DPL_FOURS (lib/reads.glsl).
//
//   VertexRecord ─skin► PosedVertex ─triangles► TriangleFrame ─project► ProjectedSplat (splat × view) + sort depth
//   splat codes, uints: chunk records │ parents │ place │ size │ colour │ parent bytes │ detail of groups │ SH indices │ SH entries
//                       (lib/codes.glsl)
//   visibility and survivors, uints: live groups, visible splats and their sort depths (lib/visibility.glsl)
//   sort depth ─compact► SortPair ─sort► sorted splats, nearest first ─draw► pixels
//                                                           └─tiles► TileSpan by row of tiles ► entries by tile ─fill► pixels
//   TriangleFrame ─write► rows of an app's buffer
//   GeneralSplatRecord ─project.general► ProjectedSplat + sort depth ─...  (general splats: no pose, no triangles)
#ifndef DPL_SHARED_FRAME_H
#define DPL_SHARED_FRAME_H
#include "shaders/shared/limits.h"
DPL_SHARED_BEGIN

struct ViewData {            // one view of the frame. "World" is the space of the subject, which may stand elsewhere (sdk/math/placement.h)
    vec4 viewFromWorldRow0;  // rows of [scale R | t]: x right, y down, z forward, metres of the view, to which the subject is scaled
    vec4 viewFromWorldRow1;
    vec4 viewFromWorldRow2;
    vec2 focalPx;
    vec2 centrePx;                                     // principal point
    float minSlopeX, maxSlopeX, minSlopeY, maxSlopeY;  // limits of x/z and y/z in the Jacobian
    float eyeX, eyeY, eyeZ;                            // in the subject's space and metres
    float pad0;
};
DPL_SHARED_SIZE(ViewData, 96)

struct PixelPlane {  // width in metres, of the subject, of a pixel of one view at a point of the subject = axis · point + offsetM
    float axisX, axisY, axisZ;
    float offsetM;
};
DPL_SHARED_SIZE(PixelPlane, 16)

// The only uniform block, one for each subject. The CPU writes it before each frame.
struct FrameData {
    ViewData views[2];
    // Depth by which splats are sorted, the same for all subjects: sortAxis · point of the subject + sortOffsetM, in metres along the mean
    // forward axis of the views.
    float sortAxisX, sortAxisY, sortAxisZ;
    float sortStartM;           // everything that a view sees lies beyond this depth
    vec2 targetPx;              // width and height of one view
    float kappaPx2;             // low-pass of one coverage sample
    float splatsPerM2;          // avatars: density at rest that level of detail asks for; 0: all splats (lib/detail.glsl)
    uint compensated;           // 1: the low-pass preserves energy
    uint unseenComponents;      // bits of the components that no view sees (sdk/visibility/components.h)
    uint splatCount;            // of the scene set: number of records for one view
    float sortOffsetM;          // depth of the subject's origin
    float largestGrowth;        // avatars: upper bound of the factor by which level of detail and the placement enlarge splats
    float shShare;              // avatars: weight of the SH bands above 0; at 0 their coefficients are not read
    float splatsPerPixel;       // general splats: density that level of detail asks for; 0: all splats
    float finestPixelM;         // general splats: lower limit of the pixel width used for level of detail, metres
    PixelPlane pixelPlanes[2];  // general splats, by view
};
DPL_SHARED_SIZE(FrameData, 288)

struct VertexRecord {  // constant, one for each vertex
    float restX, restY, restZ;
    uint joints01;  // u16 pairs
    uint joints23;
    uint weights;     // 4 x unorm8, sum 255
    uint components;  // bits of the components that use the vertex
    uint normal;      // at rest: point of the unfolded octahedron, snorm16 x 2; read where the light of the scene is known
};
DPL_CONST uint kVertexFours = 2u;
DPL_SHARED_SIZE(VertexRecord, 16 * kVertexFours)

struct CorrectedVertexRecord {  // replaces VertexRecord in avatars with pose correctives
    float restX, restY, restZ;
    uint joints01;  // u16 pairs
    uint joints23;
    uint weights;  // 4 x unorm8, sum 255
    uint nodes01;  // control nodes, u16 pairs
    uint nodes23;
    uint nodeWeights;  // 4 x unorm8, sum 255
    uint components;   // bits of the components that use the vertex
    uint normal;       // as in VertexRecord
    uint pad0;
};
DPL_CONST uint kCorrectedVertexFours = 3u;
DPL_SHARED_SIZE(CorrectedVertexRecord, 16 * kCorrectedVertexFours)

struct PosedVertex {  // one for each vertex, written each frame
    float x, y, z;    // in the subject's space, metres
    float light;      // brightness
};
DPL_SHARED_SIZE(PosedVertex, 16)

struct TriangleRecord {  // constant, one for each triangle: frame [T1 T2 N] and inverse edge matrix D⁻¹ at rest (docs/reference/binding.md)
    float restT1X, restT1Y, restT1Z;
    float inverse00;
    float restT2X, restT2Y, restT2Z;
    float inverse01;
    float restNormalX, restNormalY, restNormalZ;
    float inverse11;
    uint corner0, corner1, corner2;  // vertex indices
    uint component;                  // its number, from 1; 0: the triangle is degenerate at rest
    float reach;  // metres at rest: largest √level · standard deviation of its splats. With level = 2 ln(255 α), α < 1/255 beyond it
    float rootLevel;   // largest √level
    uint freeSplats;   // number of its free splats
    uint gatedSplats;  // number of its single-face splats
};
DPL_CONST uint kTriangleFours = 5u;
DPL_SHARED_SIZE(TriangleRecord, 16 * kTriangleFours)

struct TriangleFrame {  // one for each triangle, written each frame
    float corner0X, corner0Y, corner0Z;
    uint shows;  // kShowsFree << view and kShowsGated << view: which splats may show in which view
    float corner1X, corner1Y, corner1Z;
    uint turnXY;  // x and y of the polar rotation as a quaternion, snorm16
    float corner2X, corner2Y, corner2Z;
    uint turnZW;                         // z and w of the quaternion
    float column0X, column0Y, column0Z;  // first column of F
    uint light01;                        // brightness at corners 0 and 1, half floats
    float column1X, column1Y, column1Z;  // second column of F
    uint light2;                         // half floats: brightness at corner 2; share of the splats' opacity that overstretching takes
};
DPL_CONST uint kTriangleFrameFours = 5u;
DPL_SHARED_SIZE(TriangleFrame, 16 * kTriangleFrameFours)

struct GeneralSplatRecord {           // constant, one for each general splat
    float centreX, centreY, centreZ;  // in the subject's space, metres
    float opacity;
    float axis1X, axis1Y, axis1Z;  // unit axes × standard deviations, metres
    float pad1;
    float axis2X, axis2Y, axis2Z;
    float pad2;
    float axis3X, axis3Y, axis3Z;
    float pad3;
};
DPL_CONST uint kGeneralSplatFours = 4u;
DPL_SHARED_SIZE(GeneralSplatRecord, 16 * kGeneralSplatFours)

struct GroupBox {  // constant: bounding box of the centres of a group of general splats
    float middleX, middleY, middleZ;
    float pad0;
    float reachX, reachY, reachZ;  // half its size, metres
    float pad1;
    float areaM2, gain, enough;  // of its SplatGroup (sdk/math/detail.h)
    float pad2;
};
DPL_CONST uint kGroupBoxFours = 3u;
DPL_SHARED_SIZE(GroupBox, 16 * kGroupBoxFours)

// One for each splat and view. All records of view 0 come first, so drawing one view does not read those of the other. 32 bytes are half a
// cache line; the records are read in depth order, so each read touches one line (lib/projected.glsl).
struct ProjectedSplat {
    vec2 centrePx;         // in the target: origin top left, pixel centres at +0.5
    float conicA, conicB;  // σ = ½(A dx² + C dy²) + B dx dy
    float conicC;
    uint opacityAndRadius;  // low half: opacity after compensation, gate and near fade, unorm16; high half: half the width outside
                            // which α < 1/255, px, as a half float; 0: hidden in this view
    uint colour;            // rgb, display-referred, 11, 11 and 10 bits
    float depthM;           // view z
};
DPL_CONST uint kProjectedFours = 2u;
DPL_SHARED_SIZE(ProjectedSplat, 16 * kProjectedFours)

// Splats in an app's buffer, in the app's layout.
struct WriteData {          // the uniform block of the kernel. The CPU writes it before each use
    vec4 worldFromOwnRow0;  // rows of [scale R | t] of the placement
    vec4 worldFromOwnRow1;
    vec4 worldFromOwnRow2;
    float eyeX, eyeY, eyeZ;  // world
    uint hasEye;             // 0: no gate, and the colour is that of SH band 0
    float scale;             // of the placement
    float shShare;           // weight of the SH bands above 0; at 0 their coefficients are not read
    uint shDegree;           // of what is written
    uint rows;               // splats that are written
    uint thinned;            // 1: those of the list of KeptRecord; 0: all
    uint elementCount;
    uint pad0, pad1;
    uvec4 elements[16];     // kWrittenElements: property, word of the first row, words from row to row, 1: halves
    vec4 shDirections[15];  // kShTurnDirections
    vec4 shInverse[21];     // kShTurnRows
};
DPL_SHARED_SIZE(WriteData, 928)

struct KeptRecord {  // constant: a splat that a level of detail keeps
    uint splat;
    uint chunkWord;  // offset of the record of its chunk
    float weight;    // factor of the opacity
    float growth;    // factor of the standard deviations
};
DPL_SHARED_SIZE(KeptRecord, 16)

struct SortPair {  // one for each survivor
    uint key;      // of its depth
    uint splat;
};
DPL_SHARED_SIZE(SortPair, 8)

struct TileSpan {  // the tiles that a splat touches in one row of tiles
    uint record;   // number of its ProjectedSplat
    uint columns;  // the first; the last in the high half
};
DPL_SHARED_SIZE(TileSpan, 8)

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
    uint searchGroupsX, searchGroupsY, searchGroupsZ;  // VkDispatchIndirectCommand over the tiles; zero when the entries fit
    uint tileEntries;                                  // entries of all tiles
    uint rowGroupsX, rowGroupsY, rowGroupsZ;  // VkDispatchIndirectCommand over segments of rows of tiles; zero when the spans do not fit
    uint tilesOverflowed;                     // 1: a list was too small, so each tile searches for its splats
    uint entryGroupsX, entryGroupsY, entryGroupsZ;  // the same; zero when the entries do not fit
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
    uint firstNode;   // in the palette: the control nodes follow the rows of the joints
    uint firstLight;  // in the palette: two rows of coefficients of the irradiance follow the nodes; 0: none
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
    uint drawInstances;  // of the draw: 1, or the number of views where the device draws views as instances
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

struct FillPush {
    uint count;  // words
    uint value;
};
struct RoundPush {
    uint widthPx;     // of one view
    uint firstPixel;  // of the view, in the buffer
    uint layer;       // of the image
};
struct ScenePush {  // reads a view's depth image of an app: stored depth = scale + offset / z
    uint widthPx, heightPx;
    uint firstPixel;       // of the view, in the buffer
    uint layer;            // of the image
    float placeX, placeY;  // of the view's top left pixel in the image, px
    float scale, offset;
};
struct ComposePush {       // a draw in an app's pass
    float placeX, placeY;  // of the picture's top left corner in the app's target, px
    uint widthPx, heightPx;
    uint view;        // read only without multiview
    uint views;       // 1 << view of those that the draw composes; others are left alone
    uint drawnFrom;   // the view in layer 0 of the image that quads fill
    uint bufferFrom;  // the view that begins the buffers
    uint tiled;       // 1: tiles filled the picture
    uint linear;      // 1: the target holds linear light, or its format encodes it; 0: display-referred values
    // Of the draw that writes depth.
    uint mesh;            // 1: of the mesh; 0: of the splats
    uint firstDepth;      // in the buffer that tiles fill: depth sums
    uint halfDepth;       // 1: these are pairs of halves
    float scale, offset;  // stored depth = scale + offset / z
};

DPL_SHARED_END
#endif
