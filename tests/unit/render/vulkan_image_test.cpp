// SPDX-License-Identifier: Apache-2.0
// Vulkan pictures against the referee, repeated frames, unusual sizes and splats, and refused input.
#include "tests/unit/render/vulkan_image.h"

#include "sdk/math/coverage.h"
#include "sdk/render/passes/tiles.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

INSTANTIATE_TEST_SUITE_P(Fill, VulkanImage, testing::Values(Fill::Quads, Fill::Tiles),
                         [](const auto& info) { return std::string(info.param == Fill::Tiles ? "Tiles" : "Quads"); });

/** Bounds of the difference from the referee. covered: smallest share of pixels that must be drawn. */
struct Bounds {
    double covered = 0.005, maxDepthErrorM = 0.02;
};

/** What the rounding of depth adds to its error. On devices that do not blend 32-bit floats the sums are halves: each blend rounds by up to
 *  2^-12 of the depth. Measured on a tube 8 m away: 0.027 m instead of 0.00001, 14 such steps. */
double depthRoundingM(const DeviceInfo& device, const ReferenceImage& want) {
    if (!device.halfDepth) return 0;
    double farthestM = 0;
    for (const double depthM : want.depthM) farthestM = std::max(farthestM, depthM);
    return farthestM * 16 / 4096;
}

/** Draws `id` with depth, prints the difference from the referee and checks the bounds. */
RenderedView expectAgrees(TestVulkan& vulkan, const std::string& name, const Result<RenderAvatarId>& id, const Pose& pose,
                          const Cameraf& camera, const ReferenceImage& want, const Bounds& bounds = {}) {
    if (!id) {
        ADD_FAILURE() << name << ": " << id.error().message;
        return {};
    }
    RenderedView image = drawOne(*vulkan.renderer, *id, pose, camera, true);
    const Difference d = compare(image, want);
    std::printf("[  IMAGE   ] %-24s: colour %.1f dB (max %.4f), alpha %.1f dB, depth max %.5f m, covered %.1f %%\n", name.c_str(), d.psnrDb,
                d.maxError, d.alphaPsnrDb, d.maxDepthErrorM, d.covered * 100);
    dumpPicture(name.c_str(), image);
    EXPECT_GT(d.covered, bounds.covered) << name;
    EXPECT_GE(d.psnrDb, kMinPsnrDb) << name;
    EXPECT_GE(d.alphaPsnrDb, kMinPsnrDb) << name;
    EXPECT_LT(d.maxDepthErrorM, bounds.maxDepthErrorM + depthRoundingM(vulkan.device, want)) << name;
    expectFilledBy(*vulkan.renderer, *id, vulkan.fill);
    return image;
}

TEST_P(VulkanImage, equalsTheReferenceInSeveralPosesAndViews) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    std::printf("[  DEVICE  ] %s\n", vulkan.renderer->name().c_str());
    struct Case {
        const char* name;
        bool singleFace;
        uint32_t shDegree;
        float bend, turn, azimuth, distanceM;
    };
    const Case cases[] = {{"rest", true, 2, 0, 0, 0, 1.8f},
                          {"bent", true, 3, 1.1f, 0.4f, 0.7f, 1.8f},
                          {"bent_back", false, 2, -0.8f, 2, 2.5f, 1.8f},
                          {"close", true, 1, 0.5f, 0, -1.2f, 0.32f},
                          {"far", false, 0, 0.3f, 1, 3.1f, 8.0f}};
    for (const Case& c : cases) {
        const auto avatar = share(makeTube({.shDegree = c.shDegree, .singleFace = c.singleFace}));
        const Pose pose = tubePose(c.bend, c.turn);
        const Cameraf camera = tubeCamera(160, 192, c.azimuth, c.distanceM);
        const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(camera));
        auto id = vulkan.renderer->addAvatar(avatar);
        expectAgrees(vulkan, c.name, id, pose, camera,
                     want);  // bound of depth: a splat at the 1/255 cut-off may flip, which moves depth by α times the tube's thickness
        if (id) vulkan.renderer->removeAvatar(*id);
    }
}

/** Draws the tube at a fraction of the size at which it was trained according to trainedPixelM. */
/** A device that cannot shade single samples takes one sample a pixel. */
TEST_P(VulkanImage, fourSamplesAPixelEqualTheReference) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const bool four = vulkan.device.fourSamples;
    for (const float size : {0.5f, 0.25f}) {
        for (uint32_t seed = 1; seed <= 3; ++seed) {
            const Cameraf trained = tubeCamera(320, 384, 0.7f * float(seed), 1.8f), camera = trained.scaled(size);
            AvatarData data = makeTube({.shDegree = seed, .seed = seed});
            const Pose pose = tubePose(0.4f * float(seed), 0.3f);
            const ReferenceImage one = renderReference(data, pose, referenceCamera(camera));
            data.trainedPixelM = pixelAtM(trained, rootPosition(data.joints, pose));
            const auto avatar = share(data);
            const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(camera));
            EXPECT_LT(compareImages(one.rgb, want.rgb).psnrDb, 45) << "one sample gives the same picture, so this case tests nothing";
            auto id = vulkan.renderer->addAvatar(avatar);
            const RenderedView image = expectAgrees(
                vulkan, (four ? "4 samples, x" : "1 sample, x") + std::to_string(size).substr(0, 4) + ", " + std::to_string(seed), id, pose,
                camera, four ? want : one);
            ASSERT_TRUE(id);
            EXPECT_TRUE(drawOne(*vulkan.renderer, *id, pose, camera).rgba == image.rgba) << "with and without depth";
            vulkan.renderer->removeAvatar(*id);
        }
    }
}

/** Opaque limbs in front of each other. Beside an outline some samples of a tile are opaque after three layers, while their neighbours
 *  still show the limb behind. */
TEST_P(VulkanImage, samplesBesideOneThatIsDoneStillSeeWhatLiesBehind) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    AvatarData data = makeTube({.splatsPerTriangle = 16, .shDegree = 0, .singleFace = false, .colourSpread = 0.3f});
    for (float& opacity : data.splats.opacity) opacity = 0.99f;
    for (Vec2f& scale : data.splats.scaleM) scale *= 0.6f;
    for (const bool four : {false, true}) {
        if (four && !vulkan.device.fourSamples) continue;
        data.trainedPixelM = four ? 1e-4f : 0;
        const auto avatar = share(data);
        const auto id = vulkan.renderer->addAvatar(avatar);
        for (const float azimuth : {0.0f, 1.57f, 3.14f, 4.71f}) {
            const Pose pose = tubePose(2.6f, 0.2f);
            const Cameraf camera = tubeCamera(97, 131, azimuth, 1.2f);
            const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(camera));
            expectAgrees(vulkan, std::string("opaque, ") + (four ? "4 samples" : "1 sample"), id, pose, camera, want);
        }
        if (id) vulkan.renderer->removeAvatar(*id);
    }
}

TEST_P(VulkanImage, anAvatarThatSaysItsTrainedPixelIsTheSameByteForByteUpToThatSize) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    AvatarData data = makeTube();
    const Pose pose = tubePose(0.5f);
    const Cameraf trained = tubeCamera(160, 192, 0.4f, 1.8f);
    auto plain = vulkan.renderer->addAvatar(share(data));
    data.trainedPixelM = pixelAtM(trained, rootPosition(data.joints, pose));
    auto sized = vulkan.renderer->addAvatar(share(data));
    ASSERT_TRUE(plain && sized);
    for (const float size : {1.5f, 1.0f, 0.85f, 0.75f}) {
        const Cameraf camera = trained.scaled(size);
        EXPECT_EQ(drawOne(*vulkan.renderer, *plain, pose, camera).rgba == drawOne(*vulkan.renderer, *sized, pose, camera).rgba,
                  size > 0.8f || !vulkan.device.fourSamples)
            << size;
    }
}

TEST_P(VulkanImage, correctivesMoveAndLightTheSurfaceAsInTheReference) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    struct Case {
        const char* name;
        test::CorrectiveOptions correctives;
        uint32_t shDegree;
        float bend, turn;
    };
    const Case cases[] = {{"moderate", {.light = 0.3f, .reach = 100}, 3, 1.1f, 0.4f},
                          {"clamped", {.modes = 5, .nodes = 40, .light = 2, .reach = 100}, 2, -0.8f, 2},
                          {"beyond", {.modes = 64, .nodes = 500, .offsetM = 0.05f, .light = 3, .reach = 0.8f}, 0, 0.9f, 1}};
    double darkest = 1, brightest = 1;
    for (const Case& c : cases) {
        const AvatarData plain = makeTube({.shDegree = c.shDegree, .colourSpread = 0.3f});
        const auto avatar = share(test::withCorrectives(plain, 6, c.correctives));
        const Pose pose = tubePose(c.bend, c.turn);
        const Cameraf camera = tubeCamera(160, 192, 0.7f, 1.6f);
        const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(camera));
        EXPECT_LT(compareImages(renderReference(plain, pose, referenceCamera(camera)).rgb, want.rgb).psnrDb, 35)
            << c.name << ": this case tests nothing";
        for (const double l : referenceCorrection(*avatar, pose).light) darkest = std::min(darkest, l), brightest = std::max(brightest, l);
        auto id = vulkan.renderer->addAvatar(avatar);
        expectAgrees(vulkan, std::string("correctives, ") + c.name, id, pose, camera, want);
        if (id) vulkan.renderer->removeAvatar(*id);
    }
    EXPECT_EQ(darkest, 0.2);
    EXPECT_EQ(brightest, 3.0);
}

TEST_P(VulkanImage, generalSplatsEqualTheReferenceAtEveryShDegree) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        StaticSplatData splats = randomStaticSplats(degree + 1, 1500, degree);
        splats.compensated = degree % 2 == 1;  // SPZ files may set it
        const Cameraf camera = tubeCamera(160, 192, 0.7f, 2.2f);
        const ReferenceImage want = renderReference(splats, referenceCamera(camera), {.compensated = splats.compensated});
        const ReferenceImage other = renderReference(splats, referenceCamera(camera), {.compensated = !splats.compensated});
        EXPECT_LT(compareImages(other.rgb, want.rgb).psnrDb, 45) << "compensation has no effect in this case";
        auto id = vulkan.renderer->addSplats(splats);
        // Splats lie up to 2 m behind each other. One that flips at the 1/255 cut-off moves depth by its α times 2 m.
        expectAgrees(vulkan, "general, SH " + std::to_string(degree), id, {}, camera, want, {.covered = 0.05, .maxDepthErrorM = 0.05});
        if (id) vulkan.renderer->removeAvatar(*id);
    }
}

/** A person-sized set in front of a wall 800 m away: with 16-bit keys the whole person would have only a few keys. */
TEST_P(VulkanImage, generalSplatsStaySortedInADeepScene) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    StaticSplatData splats = randomStaticSplats(11, 1500, 0);
    for (uint32_t i = 0; i < 100; ++i) {
        splats.position.emplace_back(float(i % 10) * 60 - 300, float(i / 10) * 60 - 300, -800);
        splats.rotation.emplace_back(1, 0, 0, 0), splats.scaleM.emplace_back(40, 40, 1), splats.opacity.push_back(0.7f);
        splats.sh.insert(splats.sh.end(), {0.3f * float(i % 3), 0.5f, -0.4f});
    }
    const Cameraf camera = tubeCamera(160, 160, 0, 2.2f);
    auto id = vulkan.renderer->addSplats(splats);
    ASSERT_TRUE(id) << id.error().message;
    const Difference d = compare(drawOne(*vulkan.renderer, *id, {}, camera), renderReference(splats, referenceCamera(camera)));
    std::printf("[  IMAGE   ] deep scene: colour %.1f dB (max %.4f)\n", d.psnrDb, d.maxError);
    EXPECT_GT(d.covered, 0.5);
    EXPECT_GE(d.psnrDb, kMinPsnrDb);
}

/** Opacity that is summed up in 16-bit floats stops two codes below 255 here. Over a bright room that is ten codes of a dark colour. */
TEST_P(VulkanImage, manyFaintLayersAreOpaqueTogether) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    StaticSplatData splats;
    for (uint32_t i = 0; i < 400; ++i) {
        splats.position.emplace_back(0, 0, 0.0005f * float(i)), splats.rotation.emplace_back(1, 0, 0, 0);
        splats.scaleM.emplace_back(1.5f), splats.opacity.push_back(0.02f), splats.sh.insert(splats.sh.end(), {1.0f, -1.7f, -1.7f});
    }
    const Cameraf camera = tubeCamera(48, 48, 0, 2.2f);
    auto id = vulkan.renderer->addSplats(splats);
    ASSERT_TRUE(id) << id.error().message;
    const RenderedView image = drawOne(*vulkan.renderer, *id, {}, camera);
    const ReferenceImage want = renderReference(splats, referenceCamera(camera));
    for (const uint32_t pixel : {24u * 48 + 24, 20u * 48 + 24, 24u * 48 + 30}) {
        EXPECT_GT(want.alpha[pixel], 0.999);
        EXPECT_EQ(image.rgba[pixel * 4 + 3], 255) << "pixel " << pixel;
    }
    EXPECT_EQ(image.rgba[3], std::lround(want.alpha[0] * 255)) << "corner";
}

TEST_P(VulkanImage, anAvatarWithCorrectivesLeavesTheNextOneAlone) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    auto plain = vulkan.renderer->addAvatar(share(makeTube()));
    auto corrected = vulkan.renderer->addAvatar(share(test::withCorrectives(makeTube(), 1)));
    ASSERT_TRUE(plain && corrected);
    const Cameraf camera = tubeCamera(96, 96, 0.5f);
    const RenderedView alone = drawOne(*vulkan.renderer, *plain, tubePose(0.6f), camera);
    const RenderedView lit = drawOne(*vulkan.renderer, *corrected, tubePose(0.6f), camera);
    EXPECT_FALSE(lit.rgba == alone.rgba);
    EXPECT_TRUE(drawOne(*vulkan.renderer, *plain, tubePose(0.6f), camera).rgba == alone.rgba);
    drawOne(*vulkan.renderer, *corrected, tubePose(-0.9f), camera);
    EXPECT_TRUE(drawOne(*vulkan.renderer, *corrected, tubePose(0.6f), camera).rgba == lit.rgba);
}

TEST_P(VulkanImage, hundredFramesAreByteIdentical) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    auto id = vulkan.renderer->addAvatar(share(makeTube()));
    ASSERT_TRUE(id) << id.error().message;
    const Cameraf camera = tubeCamera(96, 96, 0.5f);
    const RenderedView first = drawOne(*vulkan.renderer, *id, tubePose(0.6f), camera);
    for (int frame = 1; frame < 100; ++frame) {
        if (frame % 10 == 0)
            drawOne(*vulkan.renderer, *id, tubePose(0.01f * float(frame)), camera);  // another pose in between must have no effect
        ASSERT_EQ(drawOne(*vulkan.renderer, *id, tubePose(0.6f), camera).rgba, first.rgba) << "frame " << frame;
    }
}

TEST_P(VulkanImage, framesInFlightDrawWhatFramesAloneDraw) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    auto first = vulkan.renderer->addAvatar(share(makeTube())),
         second = vulkan.renderer->addAvatar(share(test::withCorrectives(makeTube({.seed = 3}), 1)));
    ASSERT_TRUE(first && second);
    const Cameraf views[2] = {tubeCamera(96, 80, 0.5f, 1.8f, -0.03f), tubeCamera(96, 80, 0.5f, 1.8f, 0.03f)};
    const RenderedView alone = drawOne(*vulkan.renderer, *first, tubePose(0.7f), views[0]),
                       other = drawOne(*vulkan.renderer, *second, tubePose(-0.4f), views[1], true);
    for (int frame = 0; frame < 12; ++frame) {  // uses each slot four times, with mixed poses, avatars and shapes, and never waits
        const float bend = 0.1f * float(frame - 4);
        ASSERT_TRUE(vulkan.renderer->draw(*first, tubePose(bend), {views, 1}, false));
        ASSERT_TRUE(vulkan.renderer->draw(*second, tubePose(bend), {views + 1, 1}, true));
        ASSERT_TRUE(vulkan.renderer->draw(*first, tubePose(-bend), views, false));
        ASSERT_TRUE(vulkan.renderer->draw(*first, tubePose(0.7f), {views, 1}, false));
    }
    ASSERT_TRUE(vulkan.renderer->draw(*second, tubePose(-0.4f), {views + 1, 1}, true));
    auto pixels = vulkan.renderer->read(*first);
    ASSERT_TRUE(pixels) << pixels.error().message;
    EXPECT_TRUE(std::equal(alone.rgba.begin(), alone.rgba.end(), (*pixels)[0].rgba.begin()));
    pixels = vulkan.renderer->read(*second);
    ASSERT_TRUE(pixels) << pixels.error().message;
    EXPECT_TRUE(std::equal(other.rgba.begin(), other.rgba.end(), (*pixels)[0].rgba.begin()));
    EXPECT_TRUE(std::equal(other.depthM.begin(), other.depthM.end(), (*pixels)[0].depthM.begin()));
    ASSERT_TRUE(vulkan.renderer->draw(*first, tubePose(0), {views, 1}, false));
    vulkan.renderer->removeAvatar(*first);  // while its frame is running
}

TEST_P(VulkanImage, drawsNothingForAnEmptyAvatarAndOneSplatForOne) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    AvatarData empty = makeTube({.splatsPerTriangle = 0});
    auto emptyId = vulkan.renderer->addAvatar(share(empty));
    ASSERT_TRUE(emptyId) << emptyId.error().message;
    const Cameraf camera = tubeCamera(64, 64, 0);
    for (uint8_t byte : drawOne(*vulkan.renderer, *emptyId, tubePose(0), camera, true).rgba) ASSERT_EQ(byte, 0);

    AvatarData one = makeTube({.splatsPerTriangle = 0, .shDegree = 0});
    const uint32_t triangle = 325;
    one.splats.uv = {{0.3f, 0.3f}};
    one.splats.phi = {0.4f};
    one.splats.scaleM = {{0.05f, 0.02f}};
    one.splats.opacity = {0.9f};
    one.splats.flags = {0};
    one.splats.sh = {0.5f, -0.3f, 0.1f};
    for (size_t t = triangle + 1; t < one.splats.triangleStart.size(); ++t) one.splats.triangleStart[t] = 1;
    one = codedOnce(one);
    auto oneId = vulkan.renderer->addAvatar(share(one));
    ASSERT_TRUE(oneId) << oneId.error().message;
    const Difference d =
        compare(drawOne(*vulkan.renderer, *oneId, tubePose(0.2f), camera), renderReference(one, tubePose(0.2f), referenceCamera(camera)));
    std::printf("[ ONE SPLAT] %.1f dB, max %.4f, covered %.2f %%\n", d.psnrDb, d.maxError, d.covered * 100);
    EXPECT_GE(d.psnrDb, kMinPsnrDb);
    EXPECT_GT(d.covered, 0.001);
    // One layer is rounded twice: the colour to 11, 11 and 10 bits in its ProjectedSplat, then the pixel to 8 bits. In blue that is at most
    // 0.9 * 0.5 / 1023 + 0.5 / 255 = 0.0024. SwiftShader reaches 0.00217 where the pixel is half way between two codes, lavapipe 0.00195.
    EXPECT_LE(d.maxError, 0.9 * 0.5 / 1023 + 0.5 / 255 + 1e-5);
}

TEST_P(VulkanImage, onePixelTargetAndBehindTheCamera) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const auto avatar = share(makeTube());
    auto id = vulkan.renderer->addAvatar(avatar);
    ASSERT_TRUE(id) << id.error().message;
    Cameraf one = tubeCamera(1, 1, 0);
    one.fx = one.fy = 4;
    const RenderedView pixel = drawOne(*vulkan.renderer, *id, tubePose(0), one, true);
    const ReferenceImage want = renderReference(*avatar, tubePose(0), referenceCamera(one));
    ASSERT_EQ(pixel.rgba.size(), 4u);
    // Hundreds of layers of α near 1/255, each rounded to a 16-bit float, then to 8 bits: alpha is off by 0.019 with quads.
    EXPECT_NEAR(pixel.rgba[3] / 255.0, want.alpha[0], 0.025);
    EXPECT_NEAR(pixel.rgba[1] / 255.0, want.rgb[1], 0.01);
    Cameraf away = tubeCamera(32, 32, 0);
    away.viewFromWorldTranslation.z = -3;  // the tube is behind the eye
    for (uint8_t byte : drawOne(*vulkan.renderer, *id, tubePose(0), away).rgba) ASSERT_EQ(byte, 0);
}

TEST_P(VulkanImage, reportsATimeForEachPassOfTheLastFrame) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    auto id = vulkan.renderer->addAvatar(share(makeTube()));
    ASSERT_TRUE(id) << id.error().message;
    drawOne(*vulkan.renderer, *id, tubePose(0), tubeCamera(64, 64, 0));
    const auto stats = vulkan.renderer->stats(*id);
    ASSERT_TRUE(stats) << stats.error().message;
    EXPECT_GT(stats->splatsDrawn, 1000u);
    EXPECT_GT(stats->residentBytes, makeTube().splats.count() * 15u);
    const std::vector<PassTime>& times = stats->passes;
    if (times.empty()) GTEST_SKIP() << "the device has no timestamps";
    double sum = 0;
    for (const PassTime& t : times) {
        EXPECT_GE(t.milliseconds, 0) << t.label;
        sum += t.milliseconds;
    }
    EXPECT_GT(sum, 0);
    EXPECT_EQ(times.front().label, "begin");
    EXPECT_EQ(times.back().label, "readback");
    EXPECT_NEAR(vulkan.renderer->timing(*id).ms, sum - times.back().milliseconds, 1e-6) << "the frame without reading it back";
    EXPECT_EQ(times.size(), 1 + 2 + 2 + 1 + 4 + 10 + 3u + (GetParam() == Fill::Tiles ? 14u : 0u));
}

// Without a low-pass a splat may be far smaller than a pixel. Then α falls so steeply from row to row that the ratio does not fit a float.
// Trained avatars have κ = 1/12 px².
constexpr float kWeakLowPassesPx2[] = {0, 0.02f, 0.075f, 0.077f, 1 / 12.0f, 0.2f};
Fill fillAt(Fill fill, float kappaPx2) {
    return kappaPx2 < kTileMinKappaPx2 ? Fill::Quads : fill;
}

TEST_P(VulkanImage, splatsSmallerThanAPixelAreDrawnWithoutALowPassToo) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    for (const float kappaPx2 : kWeakLowPassesPx2) {
        StaticSplatData splats = randomStaticSplats(7, 3000, 0, 0.004f);
        splats.kappaPx2 = kappaPx2;
        const auto id = vulkan.renderer->addSplats(splats);
        ASSERT_TRUE(id) << id.error().message;
        const Cameraf camera = tubeCamera(160, 144, 0.3f, 3);
        const RenderedView picture = drawOne(*vulkan.renderer, *id, {}, camera);
        const Difference d =
            compare(picture, renderReference(splats, referenceCamera(camera), {.kappaPx2 = kappaPx2, .compensated = false}));
        std::printf("[  IMAGE   ] kappa %.2f px²: colour %.1f dB (max %.4f), covered %.1f %%\n", double(kappaPx2), d.psnrDb, d.maxError,
                    100 * d.covered);
        EXPECT_GE(d.psnrDb, kMinPsnrDb) << kappaPx2;
        EXPECT_GT(d.covered, 0.01) << kappaPx2;
        expectFilledBy(*vulkan.renderer, *id, fillAt(GetParam(), kappaPx2));
    }
}

/** A splat without size except its low-pass, at every eighth of a pixel along the height of two tiles. */
TEST_P(VulkanImage, oneTinySplatIsRightWhereverItLiesInItsTile) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    for (const float kappaPx2 : {kTileMinKappaPx2, 1 / 12.0f}) {
        StaticSplatData splats = randomStaticSplats(1, 1, 0);
        splats.position = {{0, 0, 2}}, splats.scaleM = {{1e-5f, 1e-5f, 1e-5f}}, splats.opacity = {0.95f}, splats.kappaPx2 = kappaPx2,
        splats.compensated = false;
        const auto id = vulkan.renderer->addSplats(splats);
        ASSERT_TRUE(id) << id.error().message;
        for (int eighth = 0; eighth <= 128; ++eighth) {
            Cameraf camera;
            camera.widthPx = 5, camera.heightPx = 16, camera.fx = camera.fy = 30, camera.cx = 2.6f, camera.cy = float(eighth) / 8;
            const Difference d = compare(drawOne(*vulkan.renderer, *id, {}, camera),
                                         renderReference(splats, referenceCamera(camera), {.kappaPx2 = kappaPx2, .compensated = false}));
            // Quads blend in halves, whose steps just below 1 are 2^-11. An H200 is 0.55 codes off.
            ASSERT_LE(d.maxError, 0.5 / 255 + (GetParam() == Fill::Quads ? 1 / 4096.0 : 0) + 1e-4)
                << "κ " << kappaPx2 << ", centre at " << camera.cy;
            ASSERT_GT(d.covered, 0.005) << camera.cy;
        }
        expectFilledBy(*vulkan.renderer, *id, GetParam());
    }
}

/** With four samples a pixel, each sample has a quarter of the low-pass. */
TEST_P(VulkanImage, splatsSmallerThanASampleAreDrawnToo) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_FOUR_SAMPLES(vulkan);
    for (const float kappaPx2 : kWeakLowPassesPx2) {
        AvatarData data = makeTube({.shDegree = 0, .singleFace = false});
        for (Vec2f& scale : data.splats.scaleM) scale *= 0.15f;
        for (float& opacity : data.splats.opacity) opacity = 0.9f;
        data.kappaPx2 = kappaPx2, data.compensated = false, data.trainedPixelM = 1e-4f;
        const auto avatar = share(data);
        const auto id = vulkan.renderer->addAvatar(avatar);
        ASSERT_TRUE(id) << id.error().message;
        const Cameraf camera = tubeCamera(160, 192, 0.7f, 1.8f);
        ASSERT_TRUE(referenceFourSamples(*avatar, tubePose(0.4f), referenceCamera(camera)));
        const Difference d = compare(drawOne(*vulkan.renderer, *id, tubePose(0.4f), camera),
                                     renderReference(*avatar, tubePose(0.4f), referenceCamera(camera)));
        std::printf("[  IMAGE   ] 4 samples, kappa %.3f px²: colour %.1f dB (max %.4f), covered %.1f %%\n", double(kappaPx2), d.psnrDb,
                    d.maxError, 100 * d.covered);
        EXPECT_GE(d.psnrDb, 60) << kappaPx2;  // 57 if the lists miss splats that only reach a sample at the edge of a tile
        EXPECT_GT(d.covered, 0.01) << kappaPx2;
        expectFilledBy(*vulkan.renderer, *id, fillAt(GetParam(), kappaPx2));
        vulkan.renderer->removeAvatar(*id);
    }
}

TEST_P(VulkanImage, refusesWhatItCannotDraw) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    AvatarData broken = makeTube();
    broken.mesh.triangles[3].y = 1u << 30;
    auto refused = vulkan.renderer->addAvatar(share(broken));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::InvalidArgument);
    auto id = vulkan.renderer->addAvatar(share(makeTube()));
    ASSERT_TRUE(id);
    std::vector<RenderedView> out(1);
    const Cameraf huge = tubeCamera(1u << 20, 16, 0);
    const Status status = vulkan.renderer->render(*id, tubePose(0), {&huge, 1}, false, out);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::InvalidArgument);
    Cameraf nan = tubeCamera(16, 16, 0);
    nan.cx = NAN;
    EXPECT_FALSE(vulkan.renderer->render(*id, tubePose(0), {&nan, 1}, false, out));
    EXPECT_FALSE(vulkan.renderer->render(*id + 1, tubePose(0), {&huge, 1}, false, out));
    EXPECT_GT(drawOne(*vulkan.renderer, *id, tubePose(0), tubeCamera(32, 32, 0)).rgba.size(), 0u);  // the renderer still works
}

}  // namespace
}  // namespace dpl
