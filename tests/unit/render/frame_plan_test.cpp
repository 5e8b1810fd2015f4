// SPDX-License-Identifier: Apache-2.0
// GpuRenderer on the null backend: the steps of a frame, the objects that it creates, and what it refuses.
#include <gtest/gtest.h>

#include <algorithm>

#include "sdk/backend/null/null_backend.h"
#include "sdk/backend/shader_pack.h"
#include "sdk/math/coverage.h"
#include "sdk/render/avatar_upload.h"
#include "sdk/render/gpu_renderer.h"
#include "sdk/render/passes/tiles.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

struct NullSetup {
    std::shared_ptr<NullRecord> record = std::make_shared<NullRecord>();
    std::unique_ptr<GpuRenderer> renderer;
    explicit NullSetup(NullOptions options = {}) {
        auto backend = createNullBackend(record, options);
        EXPECT_TRUE(backend) << (backend ? "" : backend.error().message);
        renderer = std::make_unique<GpuRenderer>(std::move(*backend), "null");
    }
    Status draw(RenderAvatarId id, uint32_t width = 32, uint32_t views = 1, bool depth = false) {
        std::vector<Cameraf> cameras(views, tubeCamera(width, 16, 0));
        return renderer->draw(id, tubePose(0), cameras, depth);
    }
};

std::shared_ptr<const AvatarData> tube(TubeOptions o = {.splatsPerTriangle = 2, .rings = 6}) {
    return std::make_shared<const AvatarData>(makeTube(o));
}

std::shared_ptr<const AvatarData> correctedTube() {
    return std::make_shared<const AvatarData>(test::withCorrectives(*tube(), 1));
}

TEST(FramePlan, runsThePassesInOrder) {
    NullSetup gpu;
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id) << id.error().message;
    const Status status = gpu.draw(*id, 32, 2, true);
    ASSERT_TRUE(status) << status.error().message;
    std::vector<std::string> want = {"begin",         "pose.skin",     "pose.triangles", "chunks.mark",  "chunks.list",
                                     "splat.project", "compact.masks", "compact.scan",   "compact.args", "compact.scatter"};
    for (int round = 0; round < 2; ++round) want.insert(want.end(), {"sort.count", "sort.scan", "sort.scan", "sort.scan", "sort.scatter"});
    want.insert(want.end(), {"draw.splats", "counts"});
    EXPECT_EQ(gpu.record->lastLabels, want);
}

/** A write of an avatar into slot 0 of an app. */
Status writeSplats(GpuRenderer& renderer, RenderAvatarId id, uint32_t budget, uint64_t joined, std::vector<FrameId>& lent) {
    const Pose pose = tubePose(0.3f);
    const gpu::uvec4 position{gpu::kWritePosition, 0, 3, 0};
    int commands = 0;
    const auto lend = [&](FrameId frame, BufferId) { return lent.push_back(frame), Status(); };
    return renderer.encodeWrite({{id, &pose}, budget, 0, {}, {&position, 1}}, {0, joined, {&commands}, lend});
}

TEST(FramePlan, aWriteFollowsTheTrianglesWithFourStorageBuffers) {
    NullSetup gpu;
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id) << id.error().message;
    std::vector<FrameId> lent;
    const Status status = writeSplats(*gpu.renderer, *id, 0, 1, lent);
    ASSERT_TRUE(status) << status.error().message;
    EXPECT_EQ(gpu.record->lastLabels, (std::vector<std::string>{"begin", "pose.skin", "pose.triangles", "splat.write"}));
    const auto pack = readShaderPack(embeddedShaderPack(), "", embeddedShaderInterface());
    ASSERT_TRUE(pack);
    for (const char* name : {"write.sh0", "write.sh3"}) {
        const auto& bindings = pack->find(name)->bindings;
        EXPECT_LE(std::count_if(bindings.begin(), bindings.end(), [](const ShaderBinding& b) { return !b.uniform; }), 4)
            << "phones have four in a stage";
    }
}

TEST(FramePlan, writesOfAFrameHaveTheirOwnRecordingsWhichTheNextFrameUsesAgain) {
    NullSetup gpu;
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id) << id.error().message;
    std::vector<FrameId> first, second, third;
    for (const uint32_t budget : {0u, 5u, 0u}) ASSERT_TRUE(writeSplats(*gpu.renderer, *id, budget, 1, first));
    EXPECT_NE(first[0].value, first[2].value) << "the CPU writes the buffers of each while the other waits to run";
    const uint64_t created = gpu.record->createdObjects;
    for (const uint32_t budget : {0u, 5u, 0u}) ASSERT_TRUE(writeSplats(*gpu.renderer, *id, budget, 2, second));
    EXPECT_EQ(gpu.record->createdObjects, created);
    for (size_t k = 0; k < 3; ++k) EXPECT_EQ(first[k].value, second[k].value);
    for (uint32_t n = 0; n < kMostWritesAFrame; ++n) ASSERT_TRUE(writeSplats(*gpu.renderer, *id, 0, 3, third));
    EXPECT_FALSE(writeSplats(*gpu.renderer, *id, 0, 3, third)) << "the app begins no frames";
    const uint64_t buffers = gpu.record->liveBuffers, frames = gpu.record->liveFrames;
    for (const uint32_t budget : {5u, 6u, 7u, 8u, 9u, 10u, 11u}) ASSERT_TRUE(gpu.renderer->writtenRows(*id, budget));
    EXPECT_EQ(gpu.record->liveBuffers, buffers + 2) << "four budgets are kept";
    EXPECT_LT(gpu.record->liveFrames, frames) << "recordings go with their budget";
    gpu.renderer->removeAvatar(*id);
    EXPECT_EQ(gpu.record->liveFrames, 0u);
}

TEST(FramePlan, depthOfTheMeshFollowsSkinningAndCostsOtherFramesNothing) {
    for (const uint32_t splatsPerTriangle : {2u, 0u}) {
        NullSetup gpu;
        auto id = gpu.renderer->addAvatar(tube({.splatsPerTriangle = splatsPerTriangle, .rings = 6}));
        ASSERT_TRUE(id) << id.error().message;
        FrameWants wants;
        wants.meshDepth = true;
        const Cameraf camera = tubeCamera(32, 16, 0);
        ASSERT_TRUE(gpu.draw(*id));
        EXPECT_EQ(std::count(gpu.record->lastLabels.begin(), gpu.record->lastLabels.end(), "mesh.depth"), 0);
        const auto draw = [&] { return gpu.renderer->draw(*id, tubePose(0), {&camera, 1}, wants); };
        const Status status = draw();
        ASSERT_TRUE(status) << status.error().message;
        const std::vector<std::string> want = {"begin", "pose.skin", "mesh.clear", "mesh.depth"};
        EXPECT_EQ(std::vector<std::string>(gpu.record->lastLabels.begin(), gpu.record->lastLabels.begin() + 4), want);
        auto pixels = gpu.renderer->read(*id);
        ASSERT_TRUE(pixels) << pixels.error().message;
        EXPECT_EQ((*pixels)[0].meshDepthM.size(), 32u * 16u);
        EXPECT_TRUE((*pixels)[0].depthM.empty());
        const uint64_t created = gpu.record->createdObjects;
        ASSERT_TRUE(draw() && gpu.renderer->read(*id));
        EXPECT_EQ(gpu.record->createdObjects, created) << "a warm frame creates nothing";
        gpu.renderer->removeAvatar(*id);
        EXPECT_EQ(gpu.record->liveBuffers + gpu.record->liveTargets + gpu.record->liveFrames, 0u);
    }
}

TEST(FramePlan, aSceneIsUploadedWithoutAWaitAndCostsOtherFramesNothing) {
    for (const Fill fill : {Fill::Quads, Fill::Tiles}) {
        NullSetup gpu;
        gpu.renderer->setFill(fill);
        auto id = gpu.renderer->addAvatar(tube());
        ASSERT_TRUE(id) << id.error().message;
        ASSERT_TRUE(gpu.draw(*id));
        const std::vector<std::string> without = gpu.record->lastLabels;
        const Cameraf camera = tubeCamera(32, 16, 0);
        const std::vector<float> scene(32 * 16, 2.0f);
        FrameWants wants;
        wants.sceneDepthM[0] = scene;
        const auto draw = [&] { return gpu.renderer->draw(*id, tubePose(0), {&camera, 1}, wants); };
        const Status status = draw();
        ASSERT_TRUE(status) << status.error().message;
        std::vector<std::string> with = gpu.record->lastLabels;
        EXPECT_EQ(std::erase(with, "tiles.scene"), fill == Fill::Tiles ? 1u : 0u);
        EXPECT_EQ(with, without);
        const uint64_t created = gpu.record->createdObjects;
        for (int i = 0; i < 5; ++i) ASSERT_TRUE(draw());
        ASSERT_TRUE(gpu.draw(*id));
        EXPECT_EQ(gpu.record->createdObjects, created) << "a warm frame creates nothing";
        EXPECT_EQ(gpu.record->lastLabels, without);
        gpu.renderer->removeAvatar(*id);
        EXPECT_EQ(gpu.record->liveBuffers + gpu.record->liveTargets + gpu.record->liveFrames, 0u);
    }
}

TEST(FramePlan, anotherLevelOfDetailIsTheSameFrame) {
    NullSetup gpu;
    const auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id) << id.error().message;
    ASSERT_TRUE(gpu.draw(*id));
    const std::vector<std::string> without = gpu.record->lastLabels;
    const uint64_t created = gpu.record->createdObjects;
    float before = 1.01f;
    for (const float perPixel : {1.0f, 0.1f, 0.01f}) {
        gpu.renderer->setDetail({perPixel, 0});
        ASSERT_TRUE(gpu.draw(*id));
        EXPECT_EQ(gpu.record->lastLabels, without);
        EXPECT_LT(gpu.renderer->stats(*id)->detailShare, before);
        before = gpu.renderer->stats(*id)->detailShare;
    }
    EXPECT_EQ(gpu.record->createdObjects, created) << "nothing is made when the level changes";
}

TEST(FramePlan, timingIsThatOfTheLastFinishedDrawWithItsOwnSplats) {
    NullSetup gpu;
    const auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id) << id.error().message;
    EXPECT_EQ(gpu.renderer->timing(*id).frame, 0u) << "nothing was drawn";
    EXPECT_EQ(gpu.renderer->timing(*id + 1).frame, 0u) << "no such avatar";
    gpu.record->frameMs = 2.5;
    ASSERT_TRUE(gpu.draw(*id));
    const FrameTiming first = gpu.renderer->timing(*id);
    EXPECT_EQ(first.frame, 1u);
    EXPECT_EQ(first.ms, 2.5);
    EXPECT_GT(first.drawn, 0u);
    EXPECT_EQ(first.drawn, first.last.wantedDrawn);
    EXPECT_EQ(first.last.kept, first.last.wantedKept);
    gpu.record->holdFrames = true;  // in flight from now on
    gpu.renderer->setDetail({0, 0, {0, uint32_t(first.last.kept / 3)}});
    for (int n = 0; n < 2; ++n) {
        ASSERT_TRUE(gpu.draw(*id));
        const FrameTiming running = gpu.renderer->timing(*id);
        EXPECT_EQ(running.frame, 1u);
        EXPECT_EQ(running.drawn, first.drawn) << "of the finished frame";
        EXPECT_LE(running.last.kept, first.last.kept / 3) << "of the last draw";
        EXPECT_EQ(running.last.wantedKept, first.last.wantedKept);
    }
    EXPECT_EQ(gpu.record->waits, 0u);
    ASSERT_TRUE(gpu.renderer->read(*id));  // waits for the last frame
    EXPECT_EQ(gpu.renderer->timing(*id).frame, 3u);
    EXPECT_LE(gpu.renderer->timing(*id).drawn, first.drawn / 2);
}

TEST(FramePlan, timingOfACantedPairIsThatOfBothItsFrames) {
    NullSetup gpu;
    const auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id) << id.error().message;
    gpu.record->frameMs = 2.5;
    const Cameraf canted[2] = {tubeCamera(32, 16, 0), tubeCamera(32, 16, 0.3f)};
    for (uint64_t draw = 1; draw <= 4; ++draw) {
        ASSERT_TRUE(gpu.renderer->draw(*id, tubePose(0), canted, false));
        EXPECT_EQ(gpu.renderer->timing(*id).frame, 2 * draw);
        EXPECT_EQ(gpu.renderer->timing(*id).ms, 5);
    }
    EXPECT_EQ(gpu.renderer->stats(*id)->views, 2u);
}

/** A frame that tiles fill pays for no pass of quads: it neither has a target nor clears, draws or resolves one. */
TEST(FramePlan, tilesRunBehindTheSortAndNothingIsDrawn) {
    NullSetup gpu;
    gpu.renderer->setFill(Fill::Tiles);
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id) << id.error().message;
    const Status status = gpu.draw(*id, 32, 2, true);
    ASSERT_TRUE(status) << status.error().message;
    const std::vector<std::string>& labels = gpu.record->lastLabels;
    const auto from = std::find(labels.begin(), labels.end(), "tiles.runs");
    const std::vector<std::string> want = {"tiles.runs",  "tiles.scan", "tiles.scan",   "tiles.scan", "tiles.args", "tiles.spans",
                                           "tiles.count", "tiles.scan", "tiles.scan",   "tiles.scan", "tiles.args", "tiles.entries",
                                           "tiles.clear", "tiles.fill", "tiles.search", "counts"};
    ASSERT_NE(from, labels.begin());
    EXPECT_EQ(*(from - 1), "sort.scatter");
    EXPECT_EQ(std::vector<std::string>(from, labels.end()), want);
    EXPECT_EQ(gpu.record->liveTargets, 0u);
    const uint64_t created = gpu.record->createdObjects;
    ASSERT_TRUE(gpu.draw(*id, 32, 2, true));
    EXPECT_EQ(gpu.record->createdObjects, created) << "a warm frame creates nothing";
    gpu.renderer->setFill(Fill::Quads);
    ASSERT_TRUE(gpu.draw(*id, 32, 2, true));
    EXPECT_EQ(std::count(gpu.record->lastLabels.begin(), gpu.record->lastLabels.end(), "tiles.fill"), 0);
    EXPECT_EQ(gpu.record->liveTargets, 1u);
    gpu.renderer->removeAvatar(*id);
    EXPECT_EQ(gpu.record->liveBuffers + gpu.record->liveTargets + gpu.record->liveFrames, 0u);
}

TEST(FramePlan, aSizeWhoseTilesDoNotFitTheDeviceIsFilledByQuads) {
    NullOptions options;
    options.info.maxBindingBytes = 500000;  // enough for the tube, not for the tables of 8 million pixels
    NullSetup gpu(options);
    gpu.renderer->setFill(Fill::Tiles);
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id) << id.error().message;
    ASSERT_TRUE(gpu.draw(*id, 64));
    EXPECT_EQ(std::count(gpu.record->lastLabels.begin(), gpu.record->lastLabels.end(), "tiles.fill"), 1);
    std::vector<Cameraf> wide(1, tubeCamera(8192, 1024, 0));
    ASSERT_TRUE(gpu.renderer->draw(*id, tubePose(0), wide, false));
    EXPECT_EQ(std::count(gpu.record->lastLabels.begin(), gpu.record->lastLabels.end(), "tiles.fill"), 0);
}

TEST(FramePlan, aSideOfTooManyTilesHasNoLists) {
    const DeviceInfo device{.maxBindingBytes = 1u << 30, .maxGroups = 65535};
    FrameIds ids;
    ids.allSplats = 100;
    for (const auto& [samples, mostPx] :
         {std::pair(1u, gpu::kMostTiles << gpu::kTilePxShift), std::pair(4u, gpu::kMostTiles << gpu::kFourTilePxShift)}) {
        ids.samples = samples;
        for (const auto& [widthPx, heightPx] :
             {std::pair(mostPx, 16u), std::pair(16u, mostPx), std::pair(mostPx + 1, 16u), std::pair(16u, mostPx + 1)}) {
            ids.widthPx = widthPx, ids.heightPx = heightPx;
            EXPECT_EQ(planTiles(ids, device).has_value(), std::max(widthPx, heightPx) <= mostPx)
                << widthPx << " x " << heightPx << " px, " << samples << " samples";
        }
    }
}

TEST(FramePlan, generalSplatsTakeTheSameFrameWithoutAPose) {
    NullSetup gpu;
    StaticSplatData splats = randomStaticSplats(1, 500, 2);
    auto id = gpu.renderer->addSplats(splats);
    ASSERT_TRUE(id) << id.error().message;
    const Status status = gpu.draw(*id, 32, 2, true);
    ASSERT_TRUE(status) << status.error().message;
    std::vector<std::string> want = {"begin",        "splat.project", "splat.colour",   "compact.masks",
                                     "compact.scan", "compact.args",  "compact.scatter"};
    for (int round = 0; round < 2; ++round) want.insert(want.end(), {"sort.count", "sort.scan", "sort.scan", "sort.scan", "sort.scatter"});
    want.insert(want.end(), {"draw.splats", "counts"});
    EXPECT_EQ(gpu.record->lastLabels, want);
    const uint64_t created = gpu.record->createdObjects;
    ASSERT_TRUE(gpu.draw(*id, 32, 2, true));
    EXPECT_EQ(gpu.record->createdObjects, created);
    splats.position[7].x += 900;  // reaches so far that depth keys need 24 bits
    auto scene = gpu.renderer->addSplats(splats);
    ASSERT_TRUE(scene && gpu.draw(*scene));
    EXPECT_EQ(std::count(gpu.record->lastLabels.begin(), gpu.record->lastLabels.end(), "sort.scatter"), 3);
    gpu.renderer->removeAvatar(*scene);
    gpu.renderer->removeAvatar(*id);
    EXPECT_EQ(gpu.record->liveBuffers + gpu.record->liveTargets + gpu.record->liveFrames, 0u);
}

TEST(FramePlan, refusesGeneralSplatsThatTheDeviceCannotBindAndBrokenOnes) {
    NullOptions options;
    options.info.maxBindingBytes = 4096;
    NullSetup gpu(options);
    auto tooMany = gpu.renderer->addSplats(randomStaticSplats(1, 500, 2));
    ASSERT_FALSE(tooMany);
    EXPECT_EQ(tooMany.error().code, Code::Unsupported);
    EXPECT_NE(tooMany.error().message.find("lower SH degree"), std::string::npos) << tooMany.error().message;
    NullOptions fewGroups;
    fewGroups.info.maxGroups = 3;
    NullSetup narrow(fewGroups);
    auto manyChunks =
        narrow.renderer->addAvatar(tube({.splatsPerTriangle = 4}));  // 2,560 splats in ten chunks: up to twenty workgroups of projection
    ASSERT_FALSE(manyChunks);
    EXPECT_EQ(manyChunks.error().code, Code::Unsupported);
    EXPECT_NE(manyChunks.error().message.find("chunks"), std::string::npos) << manyChunks.error().message;
    auto tooWide = narrow.renderer->addSplats(randomStaticSplats(1, 3 * gpu::kSplatGroup + 1, 0));
    ASSERT_FALSE(tooWide);
    EXPECT_NE(tooWide.error().message.find("at most 384"), std::string::npos) << tooWide.error().message;
    for (int broken = 0; broken < 4; ++broken) {
        StaticSplatData splats = randomStaticSplats(1, 3, 0);
        if (broken == 0) splats.rotation.pop_back();
        if (broken == 1) splats.scaleM.pop_back();
        if (broken == 2) splats.opacity.pop_back();
        if (broken == 3) splats.sh.pop_back();
        auto refused = gpu.renderer->addSplats(splats);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, Code::InvalidArgument);
    }
    EXPECT_EQ(gpu.record->liveBuffers, 0u);
}

TEST(FramePlan, aWarmFrameCreatesNothing) {
    for (const bool correctives : {false, true}) {
        NullSetup gpu;
        auto id = gpu.renderer->addAvatar(correctives ? correctedTube() : tube());
        ASSERT_TRUE(id);
        ASSERT_TRUE(gpu.draw(*id));
        const uint64_t created = gpu.record->createdObjects;
        for (int i = 0; i < 5; ++i) ASSERT_TRUE(gpu.draw(*id));
        EXPECT_EQ(gpu.record->createdObjects, created);
        EXPECT_EQ(gpu.record->runs, 6u);
    }
}

TEST(FramePlan, aWarmFrameCreatesNothingOnEitherSideOfTheSwitchToFourSamples) {
    for (const Fill fill : {Fill::Quads, Fill::Tiles}) {
        NullSetup gpu;
        gpu.renderer->setFill(fill);
        AvatarData data = makeTube({.splatsPerTriangle = 2, .rings = 6});
        data.trainedPixelM = pixelAtM(tubeCamera(32, 16, 0), rootPosition(data.joints, tubePose(0)));
        auto id = gpu.renderer->addAvatar(std::make_shared<const AvatarData>(data));
        ASSERT_TRUE(id) << id.error().message;
        const auto drawAt = [&](float distanceM) {
            const Cameraf camera = tubeCamera(32, 16, 0, distanceM);
            return bool(gpu.renderer->draw(*id, tubePose(0), {&camera, 1}, false));
        };
        ASSERT_TRUE(drawAt(1.8f));
        const uint64_t frames = gpu.record->liveFrames, targets = fill == Fill::Quads ? 1 : 0;
        EXPECT_EQ(gpu.record->liveTargets, targets);
        ASSERT_TRUE(drawAt(8));
        EXPECT_EQ(gpu.record->liveFrames, 2 * frames) << "another number of samples is another frame";
        EXPECT_EQ(gpu.record->liveTargets, 2 * targets);
        const uint64_t created = gpu.record->createdObjects;
        EXPECT_EQ(std::count(gpu.record->lastLabels.begin(), gpu.record->lastLabels.end(), "tiles.fill"), fill == Fill::Tiles ? 1 : 0);
        for (int i = 0; i < 6; ++i) ASSERT_TRUE(drawAt(i % 2 ? 1.8f : 8));
        EXPECT_EQ(gpu.record->createdObjects, created);
    }
}

TEST(FramePlan, aDeviceWithoutFourSamplesDrawsOne) {
    NullOptions options;
    options.info.fourSamples = false;
    NullSetup gpu(options);
    AvatarData data = makeTube({.splatsPerTriangle = 2, .rings = 6});
    data.trainedPixelM = 1e-5f;
    auto id = gpu.renderer->addAvatar(std::make_shared<const AvatarData>(data));
    ASSERT_TRUE(id);
    const Status status = gpu.draw(*id);
    ASSERT_TRUE(status) << status.error().message;
    EXPECT_FALSE(gpu.renderer->device().fourSamples);
}

TEST(FramePlan, waitsOnlyWhenEveryFrameInFlightIsRunning) {
    NullSetup gpu;
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id);
    gpu.record->holdFrames = true;  // no frame finishes before somebody waits for it
    for (uint32_t i = 0; i < kFramesInFlight; ++i) ASSERT_TRUE(gpu.draw(*id));
    EXPECT_EQ(gpu.record->waits, 0u);
    ASSERT_TRUE(gpu.draw(*id));
    EXPECT_EQ(gpu.record->waits, 1u) << "for the oldest frame only";
    auto stats = gpu.renderer->stats(*id);
    ASSERT_TRUE(stats);
    EXPECT_EQ(stats->waits, 1u);
    EXPECT_EQ(stats->views, 0u) << "stats wait for nothing: no frame has finished";
    gpu.record->holdFrames = false;
}

TEST(FramePlan, readsOnlyWhatWasDrawnAndMakesItsBuffersThen) {
    NullSetup gpu;
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id);
    EXPECT_FALSE(gpu.renderer->read(*id));
    ASSERT_TRUE(gpu.draw(*id, 32, 2, true));
    const uint64_t buffers = gpu.record->liveBuffers;
    auto pixels = gpu.renderer->read(*id);
    ASSERT_TRUE(pixels) << pixels.error().message;
    ASSERT_EQ(pixels->size(), 2u);
    EXPECT_EQ((*pixels)[1].rgba.size(), 32u * 16 * 4);
    EXPECT_EQ((*pixels)[1].depthM.size(), 32u * 16);
    EXPECT_EQ(gpu.record->lastLabels, std::vector<std::string>{"readback"});
    EXPECT_EQ(gpu.record->liveBuffers, buffers + 2) << "a program that never reads holds no memory for it";
    const uint64_t created = gpu.record->createdObjects;
    ASSERT_TRUE(gpu.draw(*id, 32, 2, true) && gpu.renderer->read(*id));
    EXPECT_EQ(gpu.record->createdObjects, created);
}

TEST(FramePlan, correctivesAddNoBufferAndNoPass) {
    NullSetup plain, corrected;
    auto plainId = plain.renderer->addAvatar(tube()), correctedId = corrected.renderer->addAvatar(correctedTube());
    ASSERT_TRUE(plainId && correctedId);
    const Status status = corrected.draw(*correctedId, 32, 2, true);
    ASSERT_TRUE(status) << status.error().message;
    ASSERT_TRUE(plain.draw(*plainId, 32, 2, true));
    EXPECT_EQ(corrected.record->lastLabels, plain.record->lastLabels);
    EXPECT_EQ(corrected.record->liveBuffers, plain.record->liveBuffers);
}

TEST(FramePlan, anAvatarWithoutCorrectivesUploadsNothingForThem) {
    const auto plain = tube(), corrected = correctedTube();
    EXPECT_EQ(paletteSize(*plain), 3 * plain->joints.size());
    EXPECT_EQ(paletteSize(*corrected), 3 * corrected->joints.size() + 12);
    const auto pack = [](const AvatarData& a) { return packAvatar(a, *codeSplats(a.mesh, a.splats)); };
    EXPECT_TRUE(pack(*plain).correctedVertices.empty());
    EXPECT_TRUE(pack(*corrected).vertices.empty());
    EXPECT_EQ(pack(*corrected).correctedVertices.size(), corrected->mesh.restPositions.size());
}

TEST(FramePlan, keepsAFewShapesAndFreesEverythingWithTheAvatar) {
    NullSetup gpu;
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id);
    for (uint32_t width = 8; width < 40; ++width) ASSERT_TRUE(gpu.draw(*id, width));
    EXPECT_LE(gpu.record->liveFrames, 4u * kFramesInFlight);
    EXPECT_LE(gpu.record->liveTargets, 4u);
    gpu.renderer->removeAvatar(*id);
    EXPECT_EQ(gpu.record->liveBuffers + gpu.record->liveTargets + gpu.record->liveFrames, 0u);
    EXPECT_FALSE(gpu.draw(*id));
}

TEST(FramePlan, drawsAnEmptyAvatarWithoutWork) {
    NullSetup gpu;
    auto id = gpu.renderer->addAvatar(tube({.splatsPerTriangle = 0}));
    ASSERT_TRUE(id) << id.error().message;
    const Status status = gpu.draw(*id);
    ASSERT_TRUE(status) << status.error().message;
    EXPECT_EQ(gpu.record->lastLabels.size(), 5u);
}

TEST(FramePlan, worksOnDevicesWithoutMultiview) {
    NullOptions options;
    options.info.multiview = false;
    NullSetup gpu(options);
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_TRUE(id);
    const Status status = gpu.draw(*id, 32, 2);
    EXPECT_TRUE(status) << status.error().message;
}

TEST(FramePlan, refusesAnAvatarAboveTheBindingLimitAndSaysWhatHelps) {
    NullOptions options;
    options.info.maxBindingBytes = 4096;
    NullSetup gpu(options);
    auto id = gpu.renderer->addAvatar(tube());
    ASSERT_FALSE(id);
    EXPECT_EQ(id.error().code, Code::Unsupported);
    EXPECT_NE(id.error().message.find("lower SH degree"), std::string::npos) << id.error().message;
    EXPECT_EQ(gpu.record->liveBuffers, 0u);
}

TEST(FramePlan, refusesBrokenAvatars) {
    NullSetup gpu;
    const auto expectRefused = [&](auto breakIt) {
        AvatarData a = makeTube({.splatsPerTriangle = 1, .rings = 2});
        breakIt(a);
        auto id = gpu.renderer->addAvatar(std::make_shared<const AvatarData>(std::move(a)));
        EXPECT_FALSE(id);
    };
    expectRefused([](AvatarData& a) { a.mesh.triangles[0].x = 9999; });
    expectRefused([](AvatarData& a) { a.mesh.jointIndices[0].x = 7; });
    expectRefused([](AvatarData& a) { a.splats.sh.pop_back(); });
    expectRefused([](AvatarData& a) { a.splats.triangleStart.back() += 1; });
    expectRefused([](AvatarData& a) { a.splats.triangleStart[3] = 60; });
    expectRefused([](AvatarData& a) { a.splats.shDegree = 4; });
    expectRefused([](AvatarData& a) { a.joints.clear(); });
    expectRefused([](AvatarData& a) { a.correctives = test::randomCorrectives(a, 1), a.correctives.nodeIndices[3].z = 12; });
    expectRefused([](AvatarData& a) { a.correctives = test::randomCorrectives(a, 1), a.correctives.nodes[0].x = NAN; });
    EXPECT_EQ(gpu.record->liveBuffers, 0u);
}

TEST(FramePlan, sortAxisOfTwoParallelEyesIsThatOfOne) {
    const AvatarData a = makeTube({.splatsPerTriangle = 1, .rings = 2});
    const Cameraf views[2] = {tubeCamera(32, 32, 0.37f, 1, -0.03f), tubeCamera(32, 32, 0.37f, 1, 0.03f)};
    const SplatSet splats = splatSetOf(a, *codeSplats(a.mesh, a.splats));
    const gpu::FrameData one = packFrame(splats, {views, 1}), two = packFrame(splats, views);
    EXPECT_EQ(one.sortAxisX, two.sortAxisX);  // bit for bit, so that keys and the left picture are the same in mono and stereo
    EXPECT_EQ(one.sortAxisY, two.sortAxisY);
    EXPECT_EQ(one.sortAxisZ, two.sortAxisZ);
}

}  // namespace
}  // namespace dpl
