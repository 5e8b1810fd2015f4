// SPDX-License-Identifier: Apache-2.0
// A warm frame allocates nothing and does not wait, on both renderers. A program of its own, because its operator new counts every C++
// allocation of the process, including those of libdoppel and its threads.
#include <gtest/gtest.h>

#include <array>

#include "apps/bench/count_allocations.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/ply.h"
#include "sdk/include/doppel/doppel.hpp"
#include "sdk/include/doppel/doppel_splats.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

constexpr float kTrainedPixelM = 0.011f;

std::vector<uint8_t> avatarFile() {
    AvatarData avatar = test::withCorrectives(makeTube({.splatsPerTriangle = 4, .rings = 10}), 3);
    avatar.trainedPixelM = kTrainedPixelM;
    avatar.clips = {{"sway", {0, 1}, {{1, {Quatf(1, 0, 0, 0), glm::angleAxis(0.8f, Vec3f(1, 0, 0))}}}, {Vec3f(0), Vec3f(0.1f, 0, 0)}}};
    sortSplats(avatar);
    auto bytes = writeAvatar(avatar);
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
    return bytes ? *bytes : std::vector<uint8_t>{};
}

/** far: so far away that four coverage samples per pixel are drawn. */
DplCamera cameraAt(float azimuth, float shiftM, bool far) {
    const Cameraf c = tubeCamera(120, 96, azimuth, far ? 3.2f : 1.6f, shiftM);
    DplCamera out{sizeof(DplCamera), c.widthPx, c.heightPx, c.fx, c.fy, c.cx, c.cy, {}};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) out.viewFromWorld[row * 4 + column] = c.viewFromWorldRotation[column][row];
        out.viewFromWorld[row * 4 + 3] = c.viewFromWorldTranslation[row];
    }
    return out;
}

uint64_t waits(DplAvatar avatar) {
    DplFrameStats stats{};
    stats.structSize = sizeof stats;
    EXPECT_EQ(dplGetFrameStats(avatar, &stats), DPL_OK) << dplGetLastError();
    EXPECT_GT(stats.splatsDrawn, 100u);
    return stats.waits;
}

/** Sets a level of detail that depends on t and a frame budget that no frame can keep, or neither. */
void setDetail(DplContext context, bool on, float t) {
    const DplDetail detail{sizeof(DplDetail), on ? 0.05f + 2 * t : 0, on && t > 0.5f ? uint32_t(600 - 300 * t) : 0};
    EXPECT_EQ(dplSetDetail(context, &detail), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplSetFrameBudget(context, on ? 1e-4 : 0), DPL_OK) << dplGetLastError();
}

/** Draws `frames` frames with new poses and views, three in flight, and returns the number of allocations. */
uint64_t playFrames(DplContext context, DplAvatar avatar, int frames, uint32_t viewCount, uint32_t flags, bool scene = false,
                    DplAvatar other = nullptr, bool detail = false) {
    const DplAvatar both[2] = {avatar, other};
    uint64_t allocations = 0;
    std::vector<uint8_t> pixels[2] = {std::vector<uint8_t>(120 * 96 * 4), std::vector<uint8_t>(120 * 96 * 4)};
    DplImage images[2];
    for (int v = 0; v < 2; ++v) images[v] = {sizeof(DplImage), 0, pixels[v].data(), pixels[v].size(), 0, nullptr, 0};
    for (int frame = 0; frame < frames; ++frame) {
        const float t = float(frame) / float(frames), half = 0.4f * t;
        DplCamera cameras[2] = {cameraAt(t, -0.03f, frame % 2), cameraAt(t, 0.03f, frame % 2)};
        const float rotations[8] = {0, 0, 0, 1, std::sin(half), 0, 0, std::cos(half)}, root[3] = {0, 0.1f * t, 0};
        const std::vector<float> sceneDepthM(120 * 96, scene ? 1.6f + 0.1f * t : 0.0f);
        for (DplCamera& camera : cameras)
            if (scene) camera.sceneDepthM = sceneDepthM.data(), camera.sceneDepthCount = sceneDepthM.size();
        AllocationCount count;
        setDetail(context, detail, t);
        const float placed[12] = {1, 0, 0, 0.05f * t, 0, 1, 0, 0, 0, 0, 1, 0};
        EXPECT_EQ(dplSetTransform(avatar, placed), DPL_OK) << dplGetLastError();
        const DplResult posed = frame % 2 ? dplSetPose(avatar, rotations, 2, root) : dplSetPoseFromClip(avatar, 0, t, DPL_TRUE);
        const DplResult drawn =
            other ? dplDrawTogether(context, both, 2, cameras, viewCount, flags) : dplDraw(context, avatar, cameras, viewCount, flags);
        allocations += count.stop();
        EXPECT_EQ(posed, DPL_OK) << dplGetLastError();
        EXPECT_EQ(drawn, DPL_OK) << dplGetLastError();
        if (frame % 3 != 2) continue;
        EXPECT_EQ(dplReadImages(context, avatar, images, viewCount), DPL_OK) << dplGetLastError();  // waits for the device
    }
    return allocations;
}

void expectWarmFramesAreFree(DplRenderer renderer, DplFill fill = DPL_FILL_AUTO) {
    const DplContextInfo info{sizeof(DplContextInfo), renderer, 2, 0, fill, nullptr};
    DplContext context = nullptr;
    if (const DplResult made = dplCreateContext(&info, &context); made == DPL_ERROR_UNSUPPORTED) GTEST_SKIP() << dplGetLastError();
    const std::vector<uint8_t> bytes = avatarFile();
    DplAvatar avatar = nullptr;
    ASSERT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &avatar), DPL_OK) << dplGetLastError();
    for (const uint32_t viewCount : {1u, 2u}) {
        for (const uint32_t flags : {0u, uint32_t(DPL_DRAW_DEPTH), uint32_t(DPL_DRAW_MESH_DEPTH)}) {
            EXPECT_GT(playFrames(context, avatar, 9, viewCount, flags), 0u) << "the counter counts nothing";
            const uint64_t waited = waits(avatar);
            EXPECT_EQ(playFrames(context, avatar, 18, viewCount, flags), 0u) << viewCount << " views, flags " << flags;
            EXPECT_EQ(waits(avatar), waited) << viewCount << " views, flags " << flags;
        }
        playFrames(context, avatar, 9, viewCount, 0, true);
        const uint64_t waited = waits(avatar);
        EXPECT_EQ(playFrames(context, avatar, 18, viewCount, 0, true), 0u) << viewCount << " views behind a scene";
        EXPECT_EQ(waits(avatar), waited) << viewCount << " views behind a scene";
    }
    float smallestShare = 2;
    for (const uint32_t viewCount : {1u, 2u}) {
        playFrames(context, avatar, 9, viewCount, 0);
        const uint64_t waited = waits(avatar);
        for (int frame = 0; frame < 6; ++frame) {
            EXPECT_EQ(playFrames(context, avatar, 6, viewCount, 0, false, nullptr, true), 0u)
                << viewCount << " views, a level of detail that changes";
            DplFrameStats stats{};
            stats.structSize = sizeof stats;
            ASSERT_EQ(dplGetFrameStats(avatar, &stats), DPL_OK);
            smallestShare = std::min(smallestShare, stats.detailShare);
        }
        EXPECT_EQ(playFrames(context, avatar, 6, viewCount, 0), 0u) << "back to all splats";
        EXPECT_EQ(waits(avatar), waited) << viewCount << " views, a level of detail that changes";
    }
    EXPECT_LT(smallestShare, 0.7f) << "nothing was left out";
    DplAvatar other = nullptr;
    ASSERT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &other), DPL_OK) << dplGetLastError();
    playFrames(context, avatar, 9, 2, DPL_DRAW_MESH_DEPTH, false, other);
    const uint64_t waited = waits(avatar);
    EXPECT_EQ(playFrames(context, avatar, 18, 2, DPL_DRAW_MESH_DEPTH, false, other), 0u) << "two avatars together";
    EXPECT_EQ(playFrames(context, avatar, 18, 2, DPL_DRAW_MESH_DEPTH, false, other, true), 0u)
        << "two avatars and a level of detail that changes";
    EXPECT_EQ(waits(avatar), waited) << "two avatars together";
    const std::vector<uint8_t> cloud = *writePly(randomStaticSplats(3, 3000, 1));
    DplAvatar general = nullptr;
    ASSERT_EQ(dplLoadAvatar(context, cloud.data(), cloud.size(), &general), DPL_OK) << dplGetLastError();
    playFrames(context, avatar, 9, 2, 0, false, general);
    const uint64_t waitedGeneral = waits(avatar);
    EXPECT_EQ(playFrames(context, avatar, 18, 2, 0, false, general, true), 0u) << "general splats and a level of detail that changes";
    EXPECT_EQ(waits(avatar), waitedGeneral) << "general splats and a level of detail that changes";
    DplFrameStats stats{};
    stats.structSize = sizeof stats;
    ASSERT_EQ(dplGetFrameStats(general, &stats), DPL_OK);
    EXPECT_LT(stats.detailShare, 0.7f) << "nothing was left out";
    EXPECT_EQ(dplDestroyAvatar(general), DPL_OK);
    EXPECT_EQ(dplDestroyAvatar(other), DPL_OK);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

/** Mixes of a player's layers, and gazes, by pictures of 10 ms. Returns the number of allocations. */
uint64_t mixFrames(doppel::Avatar& avatar, doppel::Player& player, int frames) {
    AllocationCount count;
    bool posed = true;
    for (int frame = 0; frame < frames; ++frame) {
        const int64_t nowNs = int64_t(frame) * 10'000'000;
        const std::span<const DplClipLayer> playing = player.layers(nowNs);
        std::array<DplClipLayer, 8> layers{};
        std::copy(playing.begin(), playing.end(), layers.begin());
        layers[playing.size()] = doppel::clipLayer(0, 0.01 * frame, 0.5f, 1);
        posed = posed && avatar.setPoseFromClips(std::span(layers).first(playing.size() + 1), nowNs);
        posed = posed && avatar.lookAtPoint(doppel::Gaze({std::sin(0.1f * float(frame)), 1, 2}));
    }
    const uint64_t allocations = count.stop();
    EXPECT_TRUE(posed) << dplGetLastError();
    return allocations;
}

TEST(WarmFrame, writtenSplatsAndVerticesAreFree) {
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 2);
    ASSERT_TRUE(context) << context.error().message;
    auto avatar = context->loadAvatar(avatarFile());
    ASSERT_TRUE(avatar) << avatar.error().message;
    std::vector<std::byte> bytes(1 << 22);
    const DplBufferElement splats[] = {doppel::bufferElement(DPL_SPLAT_POSITION, 0, 256),
                                       doppel::bufferElement(DPL_SPLAT_ROTATION, 12, 256),
                                       doppel::bufferElement(DPL_SPLAT_SH, 64, 256, DPL_NUMBER_HALF)};
    const DplBufferElement vertices[] = {doppel::bufferElement(DPL_VERTEX_POSITION, 0, 24),
                                         doppel::bufferElement(DPL_VERTEX_NORMAL, 12, 24)};
    const float eye[3] = {0, 1, 2};
    doppel::SplatOptions options;
    options.eye = eye, options.shDegree = 3, options.splatBudget = 900;
    const auto play = [&](int frames) {
        bool good = true;
        AllocationCount count;
        for (int frame = 0; frame < frames; ++frame) {
            good = good && avatar->setPoseFromClip(0u, double(frame) / frames);
            good = good && avatar->writeSplats(splats, bytes, options) && avatar->writeMesh(vertices, bytes);
        }
        const uint64_t allocations = count.stop();
        EXPECT_TRUE(good) << dplGetLastError();
        return allocations;
    };
    EXPECT_GT(play(3), 0u) << "the counter counts nothing";
    EXPECT_EQ(play(18), 0u);
}

TEST(WarmFrame, projectedSplatsAreFree) {
    const DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_SOFTWARE, 2, 0, DPL_FILL_AUTO, nullptr};
    DplContext context = nullptr;
    ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK) << dplGetLastError();
    const std::vector<uint8_t> bytes = avatarFile();
    DplAvatar avatar = nullptr;
    ASSERT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &avatar), DPL_OK) << dplGetLastError();
    std::vector<DplScreenSplat> splats(1 << 14);
    DplProjection made{};
    made.structSize = sizeof made;
    const auto play = [&](int frames) {
        AllocationCount count;
        for (int frame = 0; frame < frames; ++frame) {
            const float t = float(frame) / float(frames);
            const DplCamera eyes[2] = {cameraAt(t, -0.03f, frame % 2), cameraAt(t, 0.03f, frame % 2)};
            EXPECT_EQ(dplSetPoseFromClip(avatar, 0, t, DPL_TRUE), DPL_OK) << dplGetLastError();
            EXPECT_EQ(dplProject(context, &avatar, 1, eyes, 2, splats.data(), uint32_t(splats.size()), &made), DPL_OK) << dplGetLastError();
            EXPECT_GT(made.counts[1], 100u);
        }
        return count.stop();
    };
    EXPECT_GT(play(9), 0u) << "the counter counts nothing";
    EXPECT_EQ(play(18), 0u);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

TEST(WarmFrame, mixesAndGazesAllocateNothing) {
    AvatarData tube = makeTube({.splatsPerTriangle = 4, .rings = 10});
    tube.joints[1].humanoidBone = "head";
    tube.clips = {{"sway", {0, 1}, {{1, {Quatf(1, 0, 0, 0), glm::angleAxis(0.8f, Vec3f(1, 0, 0))}}}, {Vec3f(0), Vec3f(0.1f, 0, 0)}}};
    sortSplats(tube);
    const auto bytes = writeAvatar(tube);
    ASSERT_TRUE(bytes) << bytes.error().message;
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    ASSERT_TRUE(context) << context.error().message;
    auto avatar = context->loadAvatar(*bytes);
    ASSERT_TRUE(avatar) << avatar.error().message;
    doppel::Player player;
    ASSERT_TRUE(player.play(*avatar, 0, 0, {.travel = true}));
    ASSERT_TRUE(player.play(*avatar, 0, 0, {.fromS = 0.4}));
    EXPECT_GT(mixFrames(*avatar, player, 4), 0u) << "the counter counts nothing";
    EXPECT_EQ(mixFrames(*avatar, player, 60), 0u);
}

TEST(WarmFrame, allocatesAndWaitsForNothingOnTheCpu) {
    expectWarmFramesAreFree(DPL_RENDERER_SOFTWARE);
}
TEST(WarmFrame, allocatesAndWaitsForNothingOnVulkanWithQuads) {
    expectWarmFramesAreFree(DPL_RENDERER_VULKAN, DPL_FILL_QUADS);
}
TEST(WarmFrame, allocatesAndWaitsForNothingOnVulkanWithTiles) {
    expectWarmFramesAreFree(DPL_RENDERER_VULKAN, DPL_FILL_TILES);
}

}  // namespace
}  // namespace dpl
