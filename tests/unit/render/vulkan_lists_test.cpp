// SPDX-License-Identifier: Apache-2.0
// The lists of a frame: culling removes only splats that no view shows, and no list loses a splat.
#include "shaders/shared/frame.h"
#include "tests/reference/corrective_cases.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

constexpr double kMaxCulledError = 0.05;  // of one channel; 0.025 on lavapipe and on an H200, by quads and by tiles

/** A random view of a part of the subject at (0, middle, 0): from near or far, aimed past it, off-axis, with any focal length. */
Cameraf randomView(std::mt19937& random, float middle) {
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto around = [&](float reach) {
        return reach * Vec3f(2 * uniform(random) - 1, 2 * uniform(random) - 1, 2 * uniform(random) - 1);
    };
    const Vec3f target = Vec3f(0, middle, 0) + around(0.4f);
    const float azimuth = 6.2831853f * uniform(random), distance = 0.35f + 1.6f * uniform(random);
    const Vec3f eye = target + distance * Vec3f(std::sin(azimuth), 0.6f * uniform(random) - 0.3f, std::cos(azimuth));
    Cameraf c = lookAt(eye, target, 140, 112, 70 + 400 * uniform(random) * uniform(random));
    c.cx += 60 * (uniform(random) - 0.5f), c.cy += 60 * (uniform(random) - 0.5f);
    return c;
}

// Culling removes only splats that no view shows: the referee culls nothing, and no pixel differs from its by more than rounding.
TEST_P(VulkanImage, cullingLosesNoVisibleSplat) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    std::mt19937 random(5);
    uint64_t splats = 0, inView = 0, facing = 0, drawn = 0, chunks = 0, projected = 0;
    double worstDb = 1000, worstError = 0;
    for (int round = 0; round < 12; ++round) {
        const bool blob = round % 2 == 0;
        AvatarData data = blob ? randomAvatar(uint32_t(round) + 1, 8, 4, 1)
                               : test::withCorrectives(makeTube({.shDegree = 1, .colourSpread = 0.3f}), uint32_t(round));
        if (blob)
            for (float& c : data.splats.sh)
                c *= 0.3f;  // neighbours have similar colours, as on a person, so that ties of the 16-bit key do not matter here
        const auto avatar = share(std::move(data));
        const Pose pose = blob ? randomPose(*avatar, uint32_t(round)) : tubePose(1.5f * std::sin(float(round)), float(round));
        const Cameraf first = randomView(random, blob ? 1 : 0.5f);
        Cameraf second = first;
        second.viewFromWorldTranslation.x -= 0.06f;
        const Cameraf views[2] = {first, second};
        const size_t viewCount = round % 3 == 0 ? 2 : 1;
        std::vector<RenderedView> culled(viewCount);
        auto id = vulkan.renderer->addAvatar(avatar);
        ASSERT_TRUE(id);
        ASSERT_TRUE(vulkan.renderer->render(*id, pose, {views, viewCount}, true, culled));
        auto stats = vulkan.renderer->stats(*id);
        ASSERT_TRUE(stats);
        EXPECT_LE(stats->splatsDrawn, stats->splatsFacing);
        EXPECT_LE(stats->splatsFacing, stats->splatsInView);
        EXPECT_LE(stats->splatsFacing, stats->chunksProjected * gpu::kSplatGroup);
        chunks += stats->chunks, projected += stats->chunksProjected;
        splats += avatar->splats.count(), inView += stats->splatsInView, facing += stats->splatsFacing, drawn += stats->splatsDrawn;
        for (size_t v = 0; v < viewCount; ++v) {
            const Difference d = compare(culled[v], renderReference(*avatar, pose, referenceCamera(views[v])));
            worstDb = std::min({worstDb, d.psnrDb, d.alphaPsnrDb}), worstError = std::max(worstError, d.maxError);
            EXPECT_GE(d.psnrDb, kMinPsnrDb) << "round " << round << ", view " << v;
            EXPECT_GE(d.alphaPsnrDb, kMinPsnrDb) << "round " << round << ", view " << v;
            EXPECT_LE(d.maxError, kMaxCulledError) << "round " << round << ", view " << v;
        }
        vulkan.renderer->removeAvatar(*id);
    }
    std::printf("[ SURVIVORS] %llu splats, %llu in view, %llu facing, %llu drawn; worst %.1f dB, %.4f\n",
                static_cast<unsigned long long>(splats), static_cast<unsigned long long>(inView), static_cast<unsigned long long>(facing),
                static_cast<unsigned long long>(drawn), worstDb, worstError);
    EXPECT_LT(projected, chunks * 9 / 10);
    EXPECT_LT(inView, splats * 9 / 10);
    EXPECT_LT(facing, inView * 9 / 10);
    EXPECT_GT(drawn, splats / 20);
    EXPECT_LT(drawn, facing * 99 / 100);
}

// A component that no view shows is not posed. When it comes into view again it has the pose of that frame.
TEST_P(VulkanImage, whatIsOutOfViewIsNotPosedAndComesBack) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    for (const bool corrected : {false, true}) {
        const auto avatar = share(randomPerson(7, corrected, false));
        auto id = vulkan.renderer->addAvatar(avatar);
        ASSERT_TRUE(id);
        const Cameraf whole = lookAt({0, 1, 2.2f}, {0, 1, 0}, 140, 112, 120), away = lookAt({0, 1, 2.2f}, {0, 1, 6}, 140, 112, 120),
                      close = lookAt({0, 1.55f, 1}, {0, 1.6f, 0}, 140, 112, 400);
        uint32_t least = 100, most = 0, parts = 0, frame = 0;
        for (const Cameraf& view : {whole, away, whole, close, away, close, whole, close, close, close}) {
            Pose pose = randomPose(*avatar, ++frame);
            for (Quatf& q : pose.localRotations) q = glm::slerp(Quatf(1, 0, 0, 0), q, 0.2f);
            if (frame == 3) pose.rootTranslation.x += 6;  // moves the avatar out of the view
            std::vector<RenderedView> shown(1);
            ASSERT_TRUE(vulkan.renderer->render(*id, pose, {&view, 1}, true, shown));
            auto stats = vulkan.renderer->stats(*id);
            ASSERT_TRUE(stats);
            const Difference d = compare(shown[0], renderReference(*avatar, pose, referenceCamera(view)));
            EXPECT_GE(d.psnrDb, kMinPsnrDb);
            least = std::min(least, stats->componentsInView), most = std::max(most, stats->componentsInView),
            parts += stats->componentsInView > 0 && stats->componentsInView < stats->components ? 1 : 0;
        }
        EXPECT_EQ(least, 0u);
        EXPECT_GE(most, 4u);
        EXPECT_GE(parts, 2u) << "some are left out of the close-ups";
    }
}

/** The tube without its last splats. */
AvatarData tubeOf(uint32_t count, TubeOptions options) {
    AvatarData a = makeTube(options);
    SplatData& s = a.splats;
    s.uv.resize(count), s.phi.resize(count), s.scaleM.resize(count), s.opacity.resize(count), s.flags.resize(count);
    s.sh.resize(count * shCoefficientCount(s.shDegree) * 3);
    for (uint32_t& start : s.triangleStart) start = std::min(start, count);
    return a;
}

// The lists of a quad frame have room for every splat, so they cannot overflow (docs/adr/0002). The worst case is a frame in which every
// view sees every splat. The counts fill the runs of the sort exactly, or have one splat more or less.
TEST_P(VulkanImage, everyListHoldsAFrameThatShowsEverySplat) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const Cameraf views[2] = {tubeCamera(160, 144, 0.3f, 1.6f, -0.03f), tubeCamera(160, 144, 0.3f, 1.6f, 0.03f)};
    for (const uint32_t count : {gpu::kRun - 1, gpu::kRun, gpu::kRun + 1, 2 * gpu::kRun, 8 * gpu::kRun + 1, 1u}) {
        const auto avatar = share(tubeOf(count, {.splatsPerTriangle = 32, .rings = 4, .singleFace = false, .colourSpread = 0.3f}));
        auto id = vulkan.renderer->addAvatar(avatar);
        ASSERT_TRUE(id) << id.error().message;
        for (const size_t viewCount : {size_t(1), size_t(2)}) {
            std::vector<RenderedView> out(viewCount);
            const Status status = vulkan.renderer->render(*id, tubePose(0.3f), {views, viewCount}, false, out);
            ASSERT_TRUE(status) << status.error().message;
            auto stats = vulkan.renderer->stats(*id);
            ASSERT_TRUE(stats) << stats.error().message;
            EXPECT_EQ(stats->splatsDrawn, count) << viewCount << " views";
            for (size_t v = 0; v < viewCount; ++v) {
                const Difference d = compare(out[v], renderReference(*avatar, tubePose(0.3f), referenceCamera(views[v])));
                EXPECT_GE(d.psnrDb, kMinPsnrDb) << count << " splats, view " << v << " of " << viewCount;
            }
        }
        vulkan.renderer->removeAvatar(*id);
    }
}

/** Splats of half a metre, seen from inside: 400 of them overflow the list of entries, 1,500 already the list of spans. Splats that
 *  nobody sees make the lists large enough. */
TEST(VulkanTiles, aFrameThatTheListsCannotHoldHasThePixelsOfOneThatTheyHold) {
    TestVulkan vulkan(testVulkanOptions(), Fill::Tiles);
    DPL_NEED_VULKAN(vulkan);
    const Cameraf far[2] = {tubeCamera(61, 45, 0.3f, 40, -0.03f), tubeCamera(61, 45, 0.3f, 40, 0.03f)};
    const Cameraf near[2] = {tubeCamera(61, 45, 0.3f, 1.2f, -0.03f), tubeCamera(61, 45, 0.3f, 1.2f, 0.03f)};
    for (const uint32_t count : {400u, 1500u}) {
        const StaticSplatData splats = randomStaticSplats(3, count, 0, 0.5f);
        StaticSplatData padded = splats;
        for (uint32_t i = 0; i < 40000; ++i) {
            padded.position.push_back(splats.position[i % count]), padded.rotation.push_back(splats.rotation[i % count]);
            padded.scaleM.push_back(splats.scaleM[i % count]), padded.opacity.push_back(0.001f);
            padded.sh.insert(padded.sh.end(), 3, 0.0f);
        }
        auto id = vulkan.renderer->addSplats(splats), held = vulkan.renderer->addSplats(padded);
        ASSERT_TRUE(id && held);
        for (const size_t viewCount : {size_t(1), size_t(2)}) {
            for (const Cameraf* views : {far, near, far}) {  // after an overflow, lists fill the next frame again
                std::vector<RenderedView> got(viewCount), want(viewCount);
                ASSERT_TRUE(vulkan.renderer->render(*id, {}, {views, viewCount}, true, got));
                ASSERT_TRUE(vulkan.renderer->render(*held, {}, {views, viewCount}, true, want));
                const auto stats = vulkan.renderer->stats(*id), statsHeld = vulkan.renderer->stats(*held);
                ASSERT_TRUE(stats && statsHeld);
                EXPECT_EQ(stats->tilesOverflowed, views == near) << count << " splats, " << viewCount << " views";
                EXPECT_FALSE(statsHeld->tilesOverflowed);
                EXPECT_EQ(stats->splatsDrawn, statsHeld->splatsDrawn);
                if (views == near) {
                    EXPECT_EQ(stats->tileEntries > 0, count == 400) << "entries are counted where the spans fit";
                }
                for (size_t v = 0; v < viewCount; ++v) {
                    EXPECT_GT(coverage(want[v].depthM, 0.0), 0.001);
                    EXPECT_TRUE(sameButForRounding(got[v].rgba, want[v].rgba)) << count << " splats, view " << v << " of " << viewCount;
                    for (size_t i = 0; i < want[v].depthM.size(); ++i) ASSERT_NEAR(got[v].depthM[i], want[v].depthM[i], 1e-4) << i;
                }
            }
        }
        vulkan.renderer->removeAvatar(*id);
        vulkan.renderer->removeAvatar(*held);
    }
}

/** The same with four samples a pixel, against the referee. */
TEST(VulkanTiles, aFrameOfFourSamplesThatTheListsCannotHoldMatchesTheReference) {
    TestVulkan vulkan(testVulkanOptions(), Fill::Tiles);
    DPL_NEED_FOUR_SAMPLES(vulkan);
    const Cameraf views[2] = {tubeCamera(61, 45, 0.3f, 1.2f, -0.03f), tubeCamera(61, 45, 0.3f, 1.2f, 0.03f)};
    for (const uint32_t count : {150u, 2000u}) {
        AvatarData data = tubeOf(count, {.splatsPerTriangle = 16, .rings = 8, .shDegree = 0, .singleFace = false});
        for (Vec2f& scale : data.splats.scaleM) scale = Vec2f(0.5f);
        data.trainedPixelM = 1e-4f;
        const auto avatar = share(data);
        auto id = vulkan.renderer->addAvatar(avatar);
        ASSERT_TRUE(id);
        for (const size_t viewCount : {size_t(1), size_t(2)}) {
            std::vector<RenderedView> got(viewCount);
            ASSERT_TRUE(vulkan.renderer->render(*id, tubePose(0.3f), {views, viewCount}, true, got));
            auto stats = vulkan.renderer->stats(*id);
            ASSERT_TRUE(stats);
            EXPECT_TRUE(stats->tilesOverflowed);
            EXPECT_EQ(stats->tileEntries > 0, count == 150) << "entries are counted where the spans fit";
            for (size_t v = 0; v < viewCount; ++v) {
                const Difference d = compare(got[v], renderReference(*avatar, tubePose(0.3f), referenceCamera(views[v])));
                std::printf("[  TILES   ] %u splats, four samples, view %zu: %.1f dB, depth %.2g m\n", count, v, d.psnrDb,
                            d.maxDepthErrorM);
                EXPECT_GE(d.psnrDb, kMinPsnrDb) << count << " splats, view " << v << " of " << viewCount;
                EXPECT_GT(d.covered, 0.5);
            }
        }
        vulkan.renderer->removeAvatar(*id);
    }
}

}  // namespace
}  // namespace dpl
