// SPDX-License-Identifier: Apache-2.0
// The shader pack: its content, the layout of every struct in C++ and GLSL, and the refusal of damaged packs.
#include <gtest/gtest.h>

#include <map>

#include "sdk/backend/shader_pack.h"
#include "shaders/shared/frame.h"

namespace dpl {
namespace {

ShaderPack embedded() {
    auto pack = readShaderPack(embeddedShaderPack(), "the embedded pack", embeddedShaderInterface());
    EXPECT_TRUE(pack) << (pack ? "" : pack.error().message);
    return pack ? *pack : ShaderPack{};
}

using Layout = std::map<std::string, size_t>;
#define DPL_AT(type, member) \
    { #member, offsetof(gpu::type, member) }

void expectLayout(const char* name, size_t size, const Layout& layout) {
    int found = 0;
    for (const Shader& shader : embedded().shaders) {
        for (const ShaderStruct& s : shader.structs) {
            if (s.name != name) continue;
            ++found;
            EXPECT_EQ(s.size, size) << name << " in " << shader.name;
            EXPECT_EQ(s.members.size(), layout.size()) << name << " in " << shader.name;
            for (const ShaderMember& m : s.members) {
                const auto it = layout.find(m.name);
                ASSERT_NE(it, layout.end()) << name << "." << m.name << " is unknown to this test";
                EXPECT_EQ(m.offset, it->second) << name << "." << m.name << " in " << shader.name;
            }
        }
    }
    EXPECT_GT(found, 0) << name << " is in no shader";
}

TEST(ShaderPack, structsHaveTheSameOffsetsInCppAndInTheBuiltShaders) {
    using namespace gpu;
    expectLayout("ViewData", sizeof(ViewData),
                 {DPL_AT(ViewData, viewFromWorldRow0), DPL_AT(ViewData, viewFromWorldRow1), DPL_AT(ViewData, viewFromWorldRow2),
                  DPL_AT(ViewData, focalPx), DPL_AT(ViewData, centrePx), DPL_AT(ViewData, minSlopeX), DPL_AT(ViewData, maxSlopeX),
                  DPL_AT(ViewData, minSlopeY), DPL_AT(ViewData, maxSlopeY), DPL_AT(ViewData, eyeX), DPL_AT(ViewData, eyeY),
                  DPL_AT(ViewData, eyeZ), DPL_AT(ViewData, pad0)});
    expectLayout("PixelPlane", sizeof(PixelPlane),
                 {DPL_AT(PixelPlane, axisX), DPL_AT(PixelPlane, axisY), DPL_AT(PixelPlane, axisZ), DPL_AT(PixelPlane, offsetM)});
    expectLayout("FrameData", sizeof(FrameData),
                 {DPL_AT(FrameData, views), DPL_AT(FrameData, sortAxisX), DPL_AT(FrameData, sortAxisY), DPL_AT(FrameData, sortAxisZ),
                  DPL_AT(FrameData, sortStartM), DPL_AT(FrameData, targetPx), DPL_AT(FrameData, kappaPx2), DPL_AT(FrameData, splatsPerM2),
                  DPL_AT(FrameData, compensated), DPL_AT(FrameData, unseenComponents), DPL_AT(FrameData, splatCount),
                  DPL_AT(FrameData, sortOffsetM), DPL_AT(FrameData, largestGrowth), DPL_AT(FrameData, shShare),
                  DPL_AT(FrameData, splatsPerPixel), DPL_AT(FrameData, finestPixelM), DPL_AT(FrameData, pixelPlanes)});
    expectLayout("PosedVertex", sizeof(PosedVertex),
                 {DPL_AT(PosedVertex, x), DPL_AT(PosedVertex, y), DPL_AT(PosedVertex, z), DPL_AT(PosedVertex, light)});
    expectLayout("TriangleRecord", sizeof(TriangleRecord),
                 {DPL_AT(TriangleRecord, restT1X),     DPL_AT(TriangleRecord, restT1Y),     DPL_AT(TriangleRecord, restT1Z),
                  DPL_AT(TriangleRecord, inverse00),   DPL_AT(TriangleRecord, restT2X),     DPL_AT(TriangleRecord, restT2Y),
                  DPL_AT(TriangleRecord, restT2Z),     DPL_AT(TriangleRecord, inverse01),   DPL_AT(TriangleRecord, restNormalX),
                  DPL_AT(TriangleRecord, restNormalY), DPL_AT(TriangleRecord, restNormalZ), DPL_AT(TriangleRecord, inverse11),
                  DPL_AT(TriangleRecord, corner0),     DPL_AT(TriangleRecord, corner1),     DPL_AT(TriangleRecord, corner2),
                  DPL_AT(TriangleRecord, component),   DPL_AT(TriangleRecord, reach),       DPL_AT(TriangleRecord, rootLevel),
                  DPL_AT(TriangleRecord, freeSplats),  DPL_AT(TriangleRecord, gatedSplats)});
    expectLayout(
        "TriangleFrame", sizeof(TriangleFrame),
        {DPL_AT(TriangleFrame, corner0X), DPL_AT(TriangleFrame, corner0Y), DPL_AT(TriangleFrame, corner0Z), DPL_AT(TriangleFrame, shows),
         DPL_AT(TriangleFrame, corner1X), DPL_AT(TriangleFrame, corner1Y), DPL_AT(TriangleFrame, corner1Z), DPL_AT(TriangleFrame, turnXY),
         DPL_AT(TriangleFrame, corner2X), DPL_AT(TriangleFrame, corner2Y), DPL_AT(TriangleFrame, corner2Z), DPL_AT(TriangleFrame, turnZW),
         DPL_AT(TriangleFrame, column0X), DPL_AT(TriangleFrame, column0Y), DPL_AT(TriangleFrame, column0Z), DPL_AT(TriangleFrame, light01),
         DPL_AT(TriangleFrame, column1X), DPL_AT(TriangleFrame, column1Y), DPL_AT(TriangleFrame, column1Z), DPL_AT(TriangleFrame, light2)});
    expectLayout(
        "ProjectedSplat", sizeof(ProjectedSplat),
        {DPL_AT(ProjectedSplat, centrePx), DPL_AT(ProjectedSplat, conicA), DPL_AT(ProjectedSplat, conicB), DPL_AT(ProjectedSplat, conicC),
         DPL_AT(ProjectedSplat, opacityAndRadius), DPL_AT(ProjectedSplat, colour), DPL_AT(ProjectedSplat, depthM)});
    expectLayout("WriteData", sizeof(WriteData),
                 {DPL_AT(WriteData, worldFromOwnRow0), DPL_AT(WriteData, worldFromOwnRow1), DPL_AT(WriteData, worldFromOwnRow2),
                  DPL_AT(WriteData, eyeX), DPL_AT(WriteData, eyeY), DPL_AT(WriteData, eyeZ), DPL_AT(WriteData, hasEye),
                  DPL_AT(WriteData, scale), DPL_AT(WriteData, shShare), DPL_AT(WriteData, shDegree), DPL_AT(WriteData, rows),
                  DPL_AT(WriteData, thinned), DPL_AT(WriteData, elementCount), DPL_AT(WriteData, pad0), DPL_AT(WriteData, pad1),
                  DPL_AT(WriteData, elements), DPL_AT(WriteData, shDirections), DPL_AT(WriteData, shInverse)});
    expectLayout("SortPair", sizeof(SortPair), {DPL_AT(SortPair, key), DPL_AT(SortPair, splat)});
    expectLayout("TileSpan", sizeof(TileSpan), {DPL_AT(TileSpan, record), DPL_AT(TileSpan, columns)});
    // Kernels read these records as uvec4s and uvec2s, and name each word by its position.
    static_assert(offsetof(VertexRecord, restX) == 0 && offsetof(VertexRecord, restY) == 4 && offsetof(VertexRecord, restZ) == 8 &&
                  offsetof(VertexRecord, joints01) == 12 && offsetof(VertexRecord, joints23) == 16 &&
                  offsetof(VertexRecord, weights) == 20 && offsetof(VertexRecord, components) == 24 &&
                  offsetof(VertexRecord, normal) == 28);
    static_assert(offsetof(CorrectedVertexRecord, restX) == 0 && offsetof(CorrectedVertexRecord, restY) == 4 &&
                  offsetof(CorrectedVertexRecord, restZ) == 8 && offsetof(CorrectedVertexRecord, joints01) == 12 &&
                  offsetof(CorrectedVertexRecord, joints23) == 16 && offsetof(CorrectedVertexRecord, weights) == 20 &&
                  offsetof(CorrectedVertexRecord, nodes01) == 24 && offsetof(CorrectedVertexRecord, nodes23) == 28 &&
                  offsetof(CorrectedVertexRecord, nodeWeights) == 32 && offsetof(CorrectedVertexRecord, components) == 36 &&
                  offsetof(CorrectedVertexRecord, normal) == 40);
    static_assert(offsetof(PosedVertex, x) == 0 && offsetof(PosedVertex, y) == 4 && offsetof(PosedVertex, z) == 8 &&
                  offsetof(PosedVertex, light) == 12);
    static_assert(offsetof(TriangleRecord, restT1X) == 0 && offsetof(TriangleRecord, inverse00) == 12 &&
                  offsetof(TriangleRecord, restT2X) == 16 && offsetof(TriangleRecord, inverse01) == 28 &&
                  offsetof(TriangleRecord, restNormalX) == 32 && offsetof(TriangleRecord, inverse11) == 44 &&
                  offsetof(TriangleRecord, corner0) == 48 && offsetof(TriangleRecord, corner1) == 52 &&
                  offsetof(TriangleRecord, corner2) == 56 && offsetof(TriangleRecord, component) == 60 &&
                  offsetof(TriangleRecord, reach) == 64 && offsetof(TriangleRecord, rootLevel) == 68 &&
                  offsetof(TriangleRecord, freeSplats) == 72 && offsetof(TriangleRecord, gatedSplats) == 76);
    static_assert(offsetof(TriangleFrame, corner0X) == 0 && offsetof(TriangleFrame, shows) == 12 &&
                  offsetof(TriangleFrame, corner1X) == 16 && offsetof(TriangleFrame, turnXY) == 28 &&
                  offsetof(TriangleFrame, corner2X) == 32 && offsetof(TriangleFrame, turnZW) == 44 &&
                  offsetof(TriangleFrame, column0X) == 48 && offsetof(TriangleFrame, light01) == 60 &&
                  offsetof(TriangleFrame, column1X) == 64 && offsetof(TriangleFrame, light2) == 76);
    static_assert(offsetof(GeneralSplatRecord, centreX) == 0 && offsetof(GeneralSplatRecord, centreY) == 4 &&
                  offsetof(GeneralSplatRecord, centreZ) == 8 && offsetof(GeneralSplatRecord, opacity) == 12 &&
                  offsetof(GeneralSplatRecord, axis1X) == 16 && offsetof(GeneralSplatRecord, axis2X) == 32 &&
                  offsetof(GeneralSplatRecord, axis3X) == 48);
    static_assert(offsetof(GroupBox, middleX) == 0 && offsetof(GroupBox, reachX) == 16 && offsetof(GroupBox, areaM2) == 32 &&
                  offsetof(GroupBox, gain) == 36 && offsetof(GroupBox, enough) == 40);
    static_assert(offsetof(ProjectedSplat, centrePx) == 0 && offsetof(ProjectedSplat, conicA) == 8 &&
                  offsetof(ProjectedSplat, conicB) == 12 && offsetof(ProjectedSplat, conicC) == 16 &&
                  offsetof(ProjectedSplat, opacityAndRadius) == 20 && offsetof(ProjectedSplat, colour) == 24 &&
                  offsetof(ProjectedSplat, depthM) == 28);
    static_assert(offsetof(KeptRecord, splat) == 0 && offsetof(KeptRecord, chunkWord) == 4 && offsetof(KeptRecord, weight) == 8 &&
                  offsetof(KeptRecord, growth) == 12);
    static_assert(offsetof(SortPair, key) == 0 && offsetof(SortPair, splat) == 4);
    static_assert(offsetof(TileSpan, record) == 0 && offsetof(TileSpan, columns) == 4);
    expectLayout("FrameCounts", sizeof(FrameCounts), {DPL_AT(FrameCounts, visible),         DPL_AT(FrameCounts, runs),
                                                      DPL_AT(FrameCounts, trianglesInView), DPL_AT(FrameCounts, trianglesFacing),
                                                      DPL_AT(FrameCounts, runGroupsX),      DPL_AT(FrameCounts, runGroupsY),
                                                      DPL_AT(FrameCounts, runGroupsZ),      DPL_AT(FrameCounts, chunksProjected),
                                                      DPL_AT(FrameCounts, drawVertices),    DPL_AT(FrameCounts, drawInstances),
                                                      DPL_AT(FrameCounts, drawFirstVertex), DPL_AT(FrameCounts, drawFirstInstance),
                                                      DPL_AT(FrameCounts, splatsInView),    DPL_AT(FrameCounts, splatsFacing),
                                                      DPL_AT(FrameCounts, chunkGroupsX),    DPL_AT(FrameCounts, chunkGroupsY),
                                                      DPL_AT(FrameCounts, chunkGroupsZ),    DPL_AT(FrameCounts, tileSpans),
                                                      DPL_AT(FrameCounts, searchGroupsX),   DPL_AT(FrameCounts, searchGroupsY),
                                                      DPL_AT(FrameCounts, searchGroupsZ),   DPL_AT(FrameCounts, tileEntries),
                                                      DPL_AT(FrameCounts, rowGroupsX),      DPL_AT(FrameCounts, rowGroupsY),
                                                      DPL_AT(FrameCounts, rowGroupsZ),      DPL_AT(FrameCounts, tilesOverflowed),
                                                      DPL_AT(FrameCounts, entryGroupsX),    DPL_AT(FrameCounts, entryGroupsY),
                                                      DPL_AT(FrameCounts, entryGroupsZ),    DPL_AT(FrameCounts, fillGroupsX),
                                                      DPL_AT(FrameCounts, fillGroupsY),     DPL_AT(FrameCounts, fillGroupsZ),
                                                      DPL_AT(FrameCounts, depthMaxBits),    DPL_AT(FrameCounts, depthMinBitsInverted),
                                                      DPL_AT(FrameCounts, keyStart),        DPL_AT(FrameCounts, keyOffset),
                                                      DPL_AT(FrameCounts, keyScale)});
    expectLayout("TilePush", sizeof(TilePush),
                 {DPL_AT(TilePush, viewCount), DPL_AT(TilePush, columns), DPL_AT(TilePush, rows), DPL_AT(TilePush, widthPx),
                  DPL_AT(TilePush, heightPx), DPL_AT(TilePush, firstSpanSum), DPL_AT(TilePush, firstEntrySum),
                  DPL_AT(TilePush, firstRunTable), DPL_AT(TilePush, firstTileTable), DPL_AT(TilePush, spanCapacity),
                  DPL_AT(TilePush, entryCapacity), DPL_AT(TilePush, fillGroups), DPL_AT(TilePush, firstDepth), DPL_AT(TilePush, halfDepth),
                  DPL_AT(TilePush, firstScene), DPL_AT(TilePush, tileShift), DPL_AT(TilePush, reachPx), DPL_AT(TilePush, splatCount)});
    expectLayout("RowScanPush", sizeof(RowScanPush),
                 {DPL_AT(RowScanPush, perRow), DPL_AT(RowScanPush, firstTable), DPL_AT(RowScanPush, firstSum)});
    expectLayout(
        "VertexPush", sizeof(VertexPush),
        {DPL_AT(VertexPush, vertexCount), DPL_AT(VertexPush, firstNode), DPL_AT(VertexPush, firstLight), DPL_AT(VertexPush, drawn)});
    expectLayout("TrianglePush", sizeof(TrianglePush), {DPL_AT(TrianglePush, triangleCount)});
    expectLayout("MeshDepthPush", sizeof(MeshDepthPush),
                 {DPL_AT(MeshDepthPush, triangleCount), DPL_AT(MeshDepthPush, viewCount), DPL_AT(MeshDepthPush, widthPx),
                  DPL_AT(MeshDepthPush, heightPx)});
    expectLayout("SplatPush", sizeof(SplatPush),
                 {DPL_AT(SplatPush, splatCount), DPL_AT(SplatPush, allGroups), DPL_AT(SplatPush, firstGroup), DPL_AT(SplatPush, firstSplat),
                  DPL_AT(SplatPush, drawn)});
    expectLayout("CodesPush", sizeof(CodesPush),
                 {DPL_AT(CodesPush, groupCount), DPL_AT(CodesPush, allGroups), DPL_AT(CodesPush, firstGroup), DPL_AT(CodesPush, firstSplat),
                  DPL_AT(CodesPush, firstParent), DPL_AT(CodesPush, firstPlace), DPL_AT(CodesPush, firstSize),
                  DPL_AT(CodesPush, firstColour), DPL_AT(CodesPush, firstParentByte), DPL_AT(CodesPush, firstGroupDetail),
                  DPL_AT(CodesPush, firstShIndex), DPL_AT(CodesPush, firstSh), DPL_AT(CodesPush, shWords)});
    expectLayout("ChunkPush", sizeof(ChunkPush),
                 {DPL_AT(ChunkPush, groupCount), DPL_AT(ChunkPush, allGroups), DPL_AT(ChunkPush, firstGroup)});
    expectLayout("ColourPush", sizeof(ColourPush), {DPL_AT(ColourPush, splatCount), DPL_AT(ColourPush, firstSplat)});
    expectLayout("CompactPush", sizeof(CompactPush),
                 {DPL_AT(CompactPush, groupCount), DPL_AT(CompactPush, maxDepthKey), DPL_AT(CompactPush, drawnCount),
                  DPL_AT(CompactPush, endGroup)});
    expectLayout("MaskPush", sizeof(MaskPush), {DPL_AT(MaskPush, groupCount)});
    expectLayout("ScanPush", sizeof(ScanPush), {DPL_AT(ScanPush, first), DPL_AT(ScanPush, count)});
    expectLayout(
        "ArgsPush", sizeof(ArgsPush),
        {DPL_AT(ArgsPush, groupCount), DPL_AT(ArgsPush, maxDepthKey), DPL_AT(ArgsPush, drawnCount), DPL_AT(ArgsPush, drawInstances)});
    expectLayout("SortPush", sizeof(SortPush), {DPL_AT(SortPush, shift)});
    expectLayout("DrawPush", sizeof(DrawPush),
                 {DPL_AT(DrawPush, targetWidthPx), DPL_AT(DrawPush, targetHeightPx), DPL_AT(DrawPush, splatCount), DPL_AT(DrawPush, view)});
}

std::string plainName(const Shader& shader) {
    return shader.name.substr(0, shader.name.size() - (shader.name.ends_with(kTexelsSuffix) ? kTexelsSuffix.size() : 0));
}

TEST(ShaderPack, typedTwinsHaveTheBindingsOfThePlainKernel) {
    int twins = 0;
    const ShaderPack pack = embedded();
    for (const Shader& twin : pack.shaders) {
        if (!twin.name.ends_with(kTexelsSuffix)) continue;
        ++twins;
        const Shader* plain = pack.find(plainName(twin));
        ASSERT_TRUE(plain) << twin.name;
        ASSERT_EQ(plain->bindings.size(), twin.bindings.size()) << twin.name;
        EXPECT_EQ(plain->pushBytes, twin.pushBytes);
        int typed = 0;
        for (size_t i = 0; i < twin.bindings.size(); ++i) {
            const ShaderBinding &a = plain->bindings[i], &b = twin.bindings[i];
            EXPECT_EQ(a.uniform, b.uniform) << twin.name;
            EXPECT_EQ(a.writes, b.writes) << twin.name;
            EXPECT_EQ(a.reads, b.reads) << twin.name;
            EXPECT_EQ(a.texelWords, 0u) << plain->name;
            typed += b.texelWords > 0;
        }
        EXPECT_GT(typed, 0) << twin.name;
    }
    EXPECT_GT(twins, 20);
}

TEST(ShaderPack, workgroupsAreThoseThatTheSharedLimitsName) {
    std::map<std::string, uint32_t> want = {{"skin", gpu::kVertexGroup},
                                            {"skin.corrected", gpu::kVertexGroup},
                                            {"triangles", gpu::kVertexGroup},
                                            {"triangles.stereo", gpu::kVertexGroup},
                                            {"mesh.depth", gpu::kVertexGroup},
                                            {"chunks.mark", gpu::kChunkGroup},
                                            {"chunks.list", gpu::kScanGroup},
                                            {"project.general", gpu::kSplatGroup},
                                            {"project.general.stereo", gpu::kSplatGroup},
                                            {"scene.read", gpu::kSceneGroup},
                                            {"scene.read.four", gpu::kSceneGroup},
                                            {"scan.totals", gpu::kRowScanGroup},
                                            {"scan.sums", gpu::kScanGroup},
                                            {"scan.places", gpu::kRowScanGroup},
                                            {"compact.masks", gpu::kCompactGroup},
                                            {"compact.args", 1},
                                            {"compact.scatter", gpu::kCompactGroup},
                                            {"sort.count", gpu::kRunGroup},
                                            {"sort.count.packed", gpu::kRunGroup},
                                            {"sort.scatter", gpu::kRunGroup},
                                            {"sort.scatter.pack", gpu::kRunGroup},
                                            {"sort.scatter.packed", gpu::kRunGroup},
                                            {"tiles.runs", gpu::kRunGroup},
                                            {"tiles.runs.stereo", gpu::kRunGroup},
                                            {"tiles.args.spans", 1},
                                            {"tiles.args.entries", 1},
                                            {"tiles.spans", gpu::kRunGroup},
                                            {"tiles.spans.stereo", gpu::kRunGroup},
                                            {"tiles.count", gpu::kRunGroup},
                                            {"tiles.entries", gpu::kRunGroup}};
    for (const char* fill : {"tiles.fill", "tiles.fill.shuffle", "tiles.search"})
        for (const char* depth : {"", ".depth"})
            for (const char* scene : {"", ".scene"})
                for (const char* samples : {"", ".four"}) want[formatText("{}{}{}{}", fill, depth, scene, samples)] = gpu::kTileGroup;
    for (const char* name : {"project", "colour.general"})
        for (uint32_t degree = 0; degree <= 3; ++degree)
            for (const char* views : {"", ".stereo"}) want[formatText("{}.sh{}{}", name, degree, views)] = gpu::kSplatGroup;
    for (uint32_t degree = 0; degree <= 3; ++degree) want[formatText("write.sh{}", degree)] = gpu::kSplatGroup;
    for (const Shader& shader : embedded().shaders) {
        if (shader.stage != ShaderStage::Compute) continue;
        const std::string name = plainName(shader);
        ASSERT_TRUE(want.count(name)) << shader.name;
        EXPECT_EQ(shader.workgroup[0], want.at(name)) << shader.name;
        EXPECT_EQ(shader.workgroup[1] * shader.workgroup[2], 1u) << shader.name;
    }
    static_assert(gpu::kMaskWords * 32 == gpu::kSplatGroup);
}

TEST(ShaderPack, staysWithinWhatEveryVulkan11DeviceHas) {
    for (const Shader& shader : embedded().shaders) {
        int storage = 0, texels = 0;
        for (const ShaderBinding& b : shader.bindings) b.texelWords ? ++texels : storage += !b.uniform && !b.image;
        EXPECT_LE(storage, 4) << shader.name;
        EXPECT_LE(texels, 4) << shader.name;
        EXPECT_LE(shader.pushBytes, 128u) << shader.name;
        EXPECT_GT(shader.spirv.size(), 20u) << shader.name;
    }
}

TEST(ShaderPack, roundTripsAndRefusesEveryTruncationAndFlippedBytes) {
    ShaderPack small;
    small.interfaceHash = 42;
    small.shaders.push_back({.name = "one",
                             .pushBytes = 8,
                             .bindings = {{"Block", 0, false, true, true, 0}, {"Texels", 1, false, false, true, 4}},
                             .structs = {{"S", 16, {{"a", 0}, {"b", 8}}}},
                             .spirv = {1, 2, 3},
                             .mslIos = "kernel",
                             .mslMacos = "kernel"});
    const std::vector<uint8_t> bytes = writeShaderPack(small);
    auto back = readShaderPack(bytes, "test", 42);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(writeShaderPack(*back), bytes);
    for (size_t length = 0; length < bytes.size(); ++length) EXPECT_FALSE(readShaderPack({bytes.data(), length}, "test", 42)) << length;
    for (size_t i = 0; i < bytes.size(); ++i) {
        std::vector<uint8_t> flipped = bytes;
        flipped[i] ^= 0x40;
        EXPECT_FALSE(readShaderPack(flipped, "test", 42)) << i;
    }
}

TEST(ShaderPack, aStreamThatClaimsTooMuchOrHoldsTooLittleIsRefusedWithoutMakingRoom) {
    ShaderPack pack;
    const std::vector<uint8_t> good = writeShaderPack(pack);
    const auto withStream = [&](std::vector<uint8_t> stream) {
        std::vector<uint8_t> bytes(good.begin(), good.begin() + 12);  // magic and format
        const uint64_t hash = shaderHash(stream);
        bytes.insert(bytes.end(), reinterpret_cast<const uint8_t*>(&hash), reinterpret_cast<const uint8_t*>(&hash) + 8);
        bytes.insert(bytes.end(), stream.begin(), stream.end());
        return readShaderPack(bytes, "test", 0);
    };
    ASSERT_TRUE(withStream({good.begin() + 20, good.end()})) << "a pack put together by hand must be readable";
    const std::vector<uint8_t> terabyte = {0x28, 0xb5, 0x2f, 0xfd, 0xe0, 0, 0,
                                           0,    0,    0,    1,    0,    0};  // a zstd frame header with 64 bits of size
    for (const auto& stream : {std::vector<uint8_t>{}, terabyte, {good.begin() + 20, good.end() - 1}, std::vector<uint8_t>(64, 7)}) {
        const auto refused = withStream(stream);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, Code::CorruptData) << refused.error().message;
    }
}

TEST(ShaderPack, isATenthOfItsShaders) {
    size_t spirvBytes = 0;
    for (const Shader& shader : embedded().shaders) spirvBytes += shader.spirv.size() * 4;
    std::printf("%zu bytes hold %zu bytes of SPIR-V\n", embeddedShaderPack().size(), spirvBytes);
    EXPECT_LT(embeddedShaderPack().size() * 10, spirvBytes);
}

TEST(ShaderPack, otherSharedStructsAreAVersionErrorNamingBothHashes) {
    ShaderPack pack;
    pack.interfaceHash = 0xAAAA;
    auto refused = readShaderPack(writeShaderPack(pack), "old.dplpack", 0xBBBB);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::Version);
    for (const char* part : {"old.dplpack", "000000000000aaaa", "000000000000bbbb"})
        EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace dpl
