// SPDX-License-Identifier: Apache-2.0
// Whole frames through the Metal backend on the software device: one and two views, quads and tiles, one and four samples, with layered
// rendering and without, against the referee; and passes over integers against another backend, bit for bit.
#include <cmath>
#include <cstring>
#include <glm/packing.hpp>
#include <numeric>
#include <random>

#include "sdk/backend/metal/mtl_backend.h"
#include "sdk/render/gpu_renderer.h"
#include "sdk/render/passes/compact.h"
#include "sdk/render/passes/scan.h"
#include "sdk/render/passes/sort.h"
#include "sdk/render/passes/tiles.h"
#include "tests/metal/software/software_device.h"
#include "tests/reference/random_scene_depth.h"
#include "tests/unit/render/placed_pictures.h"
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

constexpr uint32_t kWidthPx = 93, kHeightPx = 91;  // no multiple of a tile
constexpr double kLeastPsnrDb = 55;                // measured 59.4 to 64.7; what is left is 16-bit blending and keys

/** A renderer on a software device of its own. At the end nothing may have been wrong, and nothing may be alive. */
struct TestMetal {
    mtl::SoftwareDevice device;
    std::unique_ptr<GpuRenderer> renderer;

    explicit TestMetal(Fill fill, const mtl::SoftwareOptions& options = {}) : device(options) {
        auto backend = mtl::createBackendOn(device.seam(), /*lent=*/false);
        EXPECT_TRUE(backend) << (backend ? "" : backend.error().message);
        if (!backend) return;
        renderer = std::make_unique<GpuRenderer>(std::move(*backend), "metal: software", fill);
    }
    ~TestMetal() {
        renderer.reset();
        for (const std::string& fault : device.takeFaults()) ADD_FAILURE() << fault;
        for (const std::string& object : device.alive()) ADD_FAILURE() << object << " was not released";
    }
};

struct Case {
    const char* name;
    Fill fill;
    uint32_t samples, views;
    bool layered;
};

class MetalFrame : public testing::TestWithParam<Case> {};

INSTANTIATE_TEST_SUITE_P(Metal, MetalFrame,
                         testing::Values(Case{"QuadsMono", Fill::Quads, 1, 1, true}, Case{"QuadsStereo", Fill::Quads, 1, 2, true},
                                         Case{"QuadsStereoDedicated", Fill::Quads, 1, 2, false},
                                         Case{"QuadsMonoFourSamples", Fill::Quads, 4, 1, false},
                                         Case{"QuadsStereoFourSamples", Fill::Quads, 4, 2, true},
                                         Case{"QuadsStereoDedicatedFourSamples", Fill::Quads, 4, 2, false},
                                         Case{"TilesMono", Fill::Tiles, 1, 1, false}, Case{"TilesStereo", Fill::Tiles, 1, 2, true},
                                         Case{"TilesMonoFourSamples", Fill::Tiles, 4, 1, true},
                                         Case{"TilesStereoFourSamples", Fill::Tiles, 4, 2, false}),
                         [](const auto& info) { return info.param.name; });

AvatarData subject(uint32_t samples) {
    AvatarData data = makeTube({.splatsPerTriangle = 4, .shDegree = 3});
    if (samples == 4) data.trainedPixelM = 1e-4f, data.kappaPx2 = 1 / 12.0f;
    return codedOnce(std::move(data));
}

std::vector<Cameraf> camerasOf(uint32_t views) {
    if (views == 1) return {tubeCamera(kWidthPx, kHeightPx, 0.6f, 1.6f)};
    return {tubeCamera(kWidthPx, kHeightPx, 0.6f, 1.6f, -0.03f), tubeCamera(kWidthPx, kHeightPx, 0.6f, 1.6f, 0.03f)};
}

TEST_P(MetalFrame, equalsTheReferee) {
    const Case& c = GetParam();
    const auto avatar = std::make_shared<const AvatarData>(subject(c.samples));
    const std::vector<Cameraf> cameras = camerasOf(c.views);
    TestMetal metal(c.fill, {.layered = c.layered});
    ASSERT_TRUE(metal.renderer);
    const auto id = metal.renderer->addAvatar(avatar);
    ASSERT_TRUE(id) << id.error().message;
    for (const float bend : {0.9f, 0.2f}) {  // the second frame meets what the first one left in every buffer
        const Pose pose = tubePose(bend, 0.4f);
        ASSERT_EQ(referenceFourSamples(*avatar, pose, referenceCamera(cameras[0])), c.samples == 4);
        std::vector<RenderedView> images(c.views);
        const Status drawn = metal.renderer->render(*id, pose, cameras, true, images);
        ASSERT_TRUE(drawn) << drawn.error().message;
        expectFilledBy(*metal.renderer, *id, c.fill);
        for (uint32_t v = 0; v < c.views; ++v) {
            const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(cameras[v]));
            const Difference d = compare(images[v], want);
            std::printf(
                "[   METAL  ] %s, bend %.1f, view %u: colour %.1f dB (max %.4f), alpha %.1f dB, depth max %.5f m, covered %.1f %%\n",
                c.name, double(bend), v, d.psnrDb, d.maxError, d.alphaPsnrDb, d.maxDepthErrorM, d.covered * 100);
            dumpPicture((std::string("metal_") + c.name).c_str(), images[v]);
            EXPECT_GE(d.psnrDb, kLeastPsnrDb);
            EXPECT_GE(d.alphaPsnrDb, kLeastPsnrDb);
            EXPECT_LT(d.maxDepthErrorM, 0.02) << "a splat at the 1/255 cut-off may flip";
            EXPECT_GT(d.covered, 0.05);
        }
        EXPECT_TRUE(c.views == 1 || images[0].rgba != images[1].rgba);
    }
}

TEST(MetalFrame, placedSubjectsEqualAMovedCameraOrMovedNumbers) {
    for (const Fill fill : {Fill::Quads, Fill::Tiles}) {
        TestMetal metal(fill);
        ASSERT_TRUE(metal.renderer);
        expectEqualToAMovedCamera(*metal.renderer);
        expectEqualToScaledNumbers(*metal.renderer);
        expectSortedInTheWorld(*metal.renderer);
    }
}

TEST(MetalFrame, framesInFlightDoNotDisturbEachOther) {
    const auto avatar = std::make_shared<const AvatarData>(subject(1));
    const std::vector<Cameraf> cameras = camerasOf(1);
    const auto last = [&](uint32_t looks) {
        TestMetal metal(Fill::Quads, {.looks = looks});
        const auto id = metal.renderer->addAvatar(avatar);
        for (int frame = 0; frame < 7; ++frame)
            EXPECT_TRUE(metal.renderer->draw(*id, tubePose(0.1f * float(frame)), cameras, FrameWants(true)));
        const auto read = metal.renderer->read(*id);
        EXPECT_TRUE(read);
        return read ? std::vector<uint8_t>((*read)[0].rgba.begin(), (*read)[0].rgba.end()) : std::vector<uint8_t>();
    };
    const auto atOnce = last(0), late = last(1000);
    EXPECT_TRUE(atOnce == late) << "command buffers that run late give the same picture";
    EXPECT_GT(atOnce.size(), 0u);
}

TEST(MetalFrame, aDepthOfTheSceneHidesWhatLiesBehind) {
    const auto avatar = std::make_shared<const AvatarData>(subject(1));
    const std::vector<Cameraf> cameras = camerasOf(1);
    const Pose pose = tubePose(0.9f, 0.4f);
    const std::vector<float> scene = randomSceneDepth(3, kWidthPx, kHeightPx, 1.6f);
    const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(cameras[0]), scene);
    EXPECT_LT(compareImages(renderReference(*avatar, pose, referenceCamera(cameras[0])).rgb, want.rgb).psnrDb, 30) << "it hides nothing";
    for (const Fill fill : {Fill::Quads, Fill::Tiles}) {
        TestMetal metal(fill);
        const auto id = metal.renderer->addAvatar(avatar);
        FrameWants wants(true);
        wants.sceneDepthM[0] = scene;
        ASSERT_TRUE(metal.renderer->draw(*id, pose, cameras, wants));
        const auto read = metal.renderer->read(*id);
        ASSERT_TRUE(read) << read.error().message;
        RenderedView image{kWidthPx, kHeightPx, {(*read)[0].rgba.begin(), (*read)[0].rgba.end()}, {}, {}};
        const Difference d = compare(image, want);
        std::printf("[   METAL  ] behind a scene, %s: %.1f dB\n", fill == Fill::Quads ? "quads" : "tiles", d.psnrDb);
        EXPECT_GE(d.psnrDb, kLeastPsnrDb);
    }
}

/** Runs compaction and sort of these visibility words on a backend, and returns counts and the sorted splats as bytes. */
std::vector<std::byte> compactedAndSorted(Backend& backend, std::span<const uint32_t> visibility, uint32_t splats) {
    FrameIds ids;
    ids.allSplats = splats, ids.allGroups = splats / gpu::kSplatGroup, ids.endGroups = {ids.allGroups};
    const auto make = [&](const char* label, uint64_t bytes, BufferMemory memory = BufferMemory::Device) {
        auto buffer = backend.createBuffer({label, std::max<uint64_t>(bytes, 16), memory});
        EXPECT_TRUE(buffer);
        return *buffer;
    };
    ids.counts = make("counts", sizeof(gpu::FrameCounts));
    ids.visibility = make("visibility", ids.visibilityWords() * 4);
    ids.survivors = make("survivors", ids.survivorWords() * 4);
    ids.pairs = make("pairs", splats * sizeof(gpu::SortPair)), ids.pairsSwap = make("swap", splats * sizeof(gpu::SortPair));
    ids.digits = {make("cells", ids.digitWords() * 4), make("sums", scanSumWords(gpu::kSortDigits) * 4),
                  make("places", ids.digitWords() * 4)};
    gpu::FrameCounts counts{};  // one subject, between 1 and 2 m
    const auto ordered = [](float v) {
        uint32_t bits;
        std::memcpy(&bits, &v, 4);
        return bits | 0x80000000u;
    };
    counts.depthMaxBits[0] = ordered(2), counts.depthMinBitsInverted[0] = ~ordered(1);
    EXPECT_TRUE(backend.write(ids.counts, 0, std::as_bytes(std::span(&counts, 1))));
    EXPECT_TRUE(backend.write(ids.visibility, 0, std::as_bytes(visibility)));
    const BufferId drawn = make("drawn", splats * 4ull, BufferMemory::Readback),
                   final = make("final", sizeof(gpu::FrameCounts), BufferMemory::Readback);
    FramePlan plan(backend);
    addCompact(plan, ids);
    addSort(plan, ids);
    plan.copy("counts", ids.counts, final);
    plan.copy("sorted", ids.pairs, drawn);
    const auto frame = plan.finish();
    EXPECT_TRUE(frame) << (frame ? "" : frame.error().message);
    const Status ran = backend.run(*frame);
    EXPECT_TRUE(ran) << (ran ? "" : ran.error().message);
    gpu::FrameCounts made;
    std::memcpy(&made, backend.mapped(final).data(), sizeof made);
    EXPECT_GT(made.visible, splats / 4);
    const auto sorted = backend.mapped(drawn).first(made.visible * 4ull), words = backend.mapped(final);
    std::vector<std::byte> bytes(words.begin(), words.end());
    bytes.insert(bytes.end(), sorted.begin(), sorted.end());
    backend.destroyFrame(*frame);
    return bytes;
}

TEST(MetalFrame, passesOverIntegersEqualAnotherBackendBitForBit) {
    auto vulkan = createTestBackend();
    if (!vulkan) GTEST_SKIP() << vulkan.error().message;
    constexpr uint32_t kSplats = 40 * gpu::kSplatGroup;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> depthM(1, 2);
    FrameIds layout;
    layout.allSplats = kSplats, layout.allGroups = kSplats / gpu::kSplatGroup;
    std::vector<uint32_t> visibility(layout.visibilityWords(), 0);
    // The layout of shaders/lib/visibility.glsl: flags and list of live groups, the range of splats of each, a depth for each splat.
    for (uint32_t i = 0; i < layout.allGroups; ++i) {
        visibility[i] = i % 7 != 3;
        visibility[layout.allGroups + i] = i;
        visibility[2 * layout.allGroups + i] = i * gpu::kSplatGroup | gpu::kSplatGroup << gpu::kSortIndexBits;
    }
    for (uint32_t i = 0; i < kSplats; ++i) {
        const float z = depthM(random);
        uint32_t bits;
        std::memcpy(&bits, &z, 4);
        visibility[3 * layout.allGroups + i] = random() % 3 == 0 ? gpu::kUnseenDepth : bits;
    }
    mtl::SoftwareDevice device;
    auto metal = mtl::createBackendOn(device.seam(), false);
    ASSERT_TRUE(metal) << metal.error().message;
    const auto want = compactedAndSorted(**vulkan, visibility, kSplats), got = compactedAndSorted(**metal, visibility, kSplats);
    EXPECT_TRUE(want == got);
    metal->reset();
    for (const std::string& fault : device.takeFaults()) ADD_FAILURE() << fault;
}

/** The lists of tiles that a backend makes of these splats, which are in depth order: counts, places, spans and entries as bytes. */
std::vector<std::byte> tileLists(Backend& backend, std::span<const gpu::ProjectedSplat> projected) {
    FrameIds ids;
    ids.allSplats = uint32_t(projected.size()), ids.widthPx = kWidthPx, ids.heightPx = kHeightPx, ids.depth = true;
    const auto tiles = planTiles(ids, {.maxBindingBytes = 128u << 20, .maxGroups = 65535});
    EXPECT_TRUE(tiles);
    const auto make = [&](const char* label, uint64_t bytes, BufferMemory memory = BufferMemory::Device) {
        auto buffer = backend.createBuffer({label, bytes, memory});
        EXPECT_TRUE(buffer);
        return *buffer;
    };
    ids.counts = make("counts", sizeof(gpu::FrameCounts)), ids.projected = make("projected", projected.size_bytes());
    ids.pairs = make("order", ids.allSplats * 4ull);
    ids.tiles = {make("cells", tiles->tableWords * 4), make("sums", tiles->sumWords * 4), make("places", tiles->tableWords * 4)};
    ids.tileSpans = make("spans", tiles->spanBytes), ids.tileEntries = make("entries", tiles->entryBytes);
    ids.tilePixels = make("pixels", tiles->pixelBytes);
    gpu::FrameCounts counts{};
    counts.visible = ids.allSplats, counts.runs = (ids.allSplats + gpu::kRun - 1) / gpu::kRun;
    counts.runGroupsX = counts.runs, counts.runGroupsY = counts.runGroupsZ = 1;
    std::vector<uint32_t> order(ids.allSplats);
    std::iota(order.begin(), order.end(), 0u);
    EXPECT_TRUE(backend.write(ids.counts, 0, std::as_bytes(std::span(&counts, 1))));
    EXPECT_TRUE(backend.write(ids.projected, 0, std::as_bytes(projected)));
    EXPECT_TRUE(backend.write(ids.pairs, 0, std::as_bytes(std::span(order))));
    const BufferId final = make("final", sizeof counts, BufferMemory::Readback),
                   places = make("places read", tiles->tableWords * 4, BufferMemory::Readback),
                   spans = make("spans read", tiles->spanBytes, BufferMemory::Readback),
                   entries = make("entries read", tiles->entryBytes, BufferMemory::Readback);
    FramePlan plan(backend);
    addTiles(plan, ids, *tiles);
    plan.copy("counts", ids.counts, final), plan.copy("places", ids.tiles.places, places);
    plan.copy("spans", ids.tileSpans, spans), plan.copy("entries", ids.tileEntries, entries);
    const auto frame = plan.finish();
    EXPECT_TRUE(frame) << (frame ? "" : frame.error().message);
    const Status ran = backend.run(*frame);
    EXPECT_TRUE(ran) << (ran ? "" : ran.error().message);
    std::memcpy(&counts, backend.mapped(final).data(), sizeof counts);
    EXPECT_EQ(counts.tilesOverflowed, 0u);
    EXPECT_GT(counts.tileSpans, ids.allSplats);
    EXPECT_GT(counts.tileEntries, counts.tileSpans);
    std::vector<std::byte> bytes;
    const std::pair<BufferId, uint64_t> used[] = {{final, sizeof counts},
                                                  {places, tiles->tableWords * 4},
                                                  {spans, counts.tileSpans * sizeof(gpu::TileSpan)},
                                                  {entries, counts.tileEntries * 4ull}};
    for (const auto& [buffer, count] : used) {
        const auto from = backend.mapped(buffer).first(count);
        bytes.insert(bytes.end(), from.begin(), from.end());
    }
    backend.destroyFrame(*frame);
    return bytes;
}

TEST(MetalFrame, listsOfTilesEqualAnotherBackendBitForBit) {
    auto vulkan = createTestBackend();
    if (!vulkan) GTEST_SKIP() << vulkan.error().message;
    std::mt19937 random(6);
    const auto between = [&](float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); };
    std::vector<gpu::ProjectedSplat> projected(3000);
    for (gpu::ProjectedSplat& p : projected) {
        const float sx = between(0.3f, 4), sy = between(0.3f, 4), r = between(-0.9f, 0.9f), across = 1 - r * r, opacity = between(0.1f, 1);
        p.centrePx = {between(-3, kWidthPx + 3.0f), between(-3, kHeightPx + 3.0f)};  // some lie outside or are cut
        p.conicA = 1 / (sx * sx * across), p.conicB = -r / (sx * sy * across), p.conicC = 1 / (sy * sy * across);
        const float radiusPx = random() % 9 == 0 ? 0 : sx * std::sqrt(2 * std::log(255 * opacity));  // 0: hidden
        p.opacityAndRadius = uint32_t(opacity * 65535) | glm::packHalf2x16({radiusPx, 0}) << 16;
        p.depthM = between(1, 2);
    }
    mtl::SoftwareDevice device;
    auto metal = mtl::createBackendOn(device.seam(), false);
    ASSERT_TRUE(metal) << metal.error().message;
    const auto want = tileLists(**vulkan, projected), got = tileLists(**metal, projected);
    ASSERT_EQ(want.size(), got.size());
    EXPECT_TRUE(want == got) << "first at byte " << std::mismatch(want.begin(), want.end(), got.begin()).first - want.begin();
    metal->reset();
    for (const std::string& fault : device.takeFaults()) ADD_FAILURE() << fault;
}

}  // namespace
}  // namespace dpl
