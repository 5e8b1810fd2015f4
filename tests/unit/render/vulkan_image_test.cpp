// The Vulkan picture against the double-precision referee, and its promises: stereo = mono, repeatable, hard sizes.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "tests/reference/image_compare.h"
#include "tests/reference/random_avatar.h"
#include "tests/reference/reference_renderer.h"
#include "sdk/math/coverage.h"
#include "shaders/shared/frame.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/tube_avatar.h"
#include "tests/unit/render/vulkan_test_device.h"

namespace dpl {
namespace {

// f16 blending leaves the 16-bit depth key (equal keys fall back to splat order) and the 1/255 cut-off: ≥ 50 dB asked for.
constexpr double kMinPsnrDb = 50;
// 8-bit blending rounds once a layer, and tails below half a level vanish: up to 5 levels where a close-up stacks many faint layers.
constexpr double kMinBytePsnrDb = 46;

/** Every test is run for both ways of filling pixels. */
class VulkanImage : public testing::TestWithParam<Fill> {};
INSTANTIATE_TEST_SUITE_P(Fill, VulkanImage, testing::Values(Fill::Quads, Fill::Tiles), [](const auto& info) { return std::string(info.param == Fill::Tiles ? "Tiles" : "Quads"); });

VulkanOptions withPreciseBlending() {
    VulkanOptions options = testVulkanOptions();
    options.preciseBlending = true;
    return options;
}

/** With vectors of 512 bits lavapipe 22.3.6 crashes in its own code generator on f16 targets and on targets of several samples. */
bool crashesOnMoreThanBytes() {
    const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH");
    return width && std::string(width) == "512";
}

/** f16 blending where the driver can. For tests that run at every width. */
VulkanOptions withPreciseBlendingOfAnyWidth() {
    VulkanOptions options = withPreciseBlending();
    options.preciseBlending = !crashesOnMoreThanBytes();
    return options;
}

std::shared_ptr<const AvatarData> share(AvatarData a) { return std::make_shared<const AvatarData>(codedOnce(std::move(a))); }

struct Difference {
    double psnrDb = 0, maxError = 0, alphaPsnrDb = 0, maxDepthErrorM = 0, covered = 0;
};

Difference compare(const RenderedView& image, const ReferenceImage& want) {
    std::vector<double> rgb, alpha;
    for (size_t i = 0; i < image.rgba.size(); i += 4) {
        for (size_t c = 0; c < 3; ++c) rgb.push_back(image.rgba[i + c] / 255.0);
        alpha.push_back(image.rgba[i + 3] / 255.0);
    }
    const ImageDifference colour = compareImages(rgb, want.rgb), coverageDifference = compareImages(alpha, want.alpha);
    Difference d{colour.psnrDb, colour.maxError, coverageDifference.psnrDb, 0, coverage(want.alpha)};
    for (size_t i = 0; i < image.depthM.size(); ++i)
        if (want.alpha[i] > 0.5) d.maxDepthErrorM = std::max(d.maxDepthErrorM, std::abs(image.depthM[i] - want.depthM[i]));
    return d;
}

void dumpPicture(const char* name, const RenderedView& image) {
    const char* folder = std::getenv("DOPPEL_TEST_PICTURES");
    if (!folder) return;
    std::FILE* file = std::fopen((std::string(folder) + "/" + name + ".ppm").c_str(), "wb");
    if (!file) return;
    std::fprintf(file, "P6\n%u %u\n255\n", image.widthPx, image.heightPx);
    for (size_t i = 0; i < image.rgba.size(); i += 4) std::fwrite(&image.rgba[i], 1, 3, file);
    std::fclose(file);
}

RenderedView drawOne(Renderer& r, RenderAvatarId id, const Pose& pose, const Cameraf& camera, bool depth = false) {
    std::vector<RenderedView> out(1);
    const Status status = r.render(id, pose, {&camera, 1}, depth, out);
    EXPECT_TRUE(status) << (status ? "" : status.error().message);
    return std::move(out[0]);
}

TEST_P(VulkanImage, equalsTheReferenceInSeveralPosesAndViews) {
    TestVulkan precise(withPreciseBlending(), GetParam()), byte(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(precise);
    std::printf("[  DEVICE  ] %s\n", precise.renderer->name().c_str());
    struct Case { const char* name; bool singleFace; uint32_t shDegree; float bend, turn, azimuth, distanceM; };
    const Case cases[] = {{"rest", true, 2, 0, 0, 0, 1.8f},          {"bent", true, 3, 1.1f, 0.4f, 0.7f, 1.8f},
                          {"bent_back", false, 2, -0.8f, 2, 2.5f, 1.8f}, {"close", true, 1, 0.5f, 0, -1.2f, 0.32f},
                          {"far", false, 0, 0.3f, 1, 3.1f, 8.0f}};
    for (const Case& c : cases) {
        const auto avatar = share(makeTube({.shDegree = c.shDegree, .singleFace = c.singleFace}));
        const Pose pose = tubePose(c.bend, c.turn);
        const Cameraf camera = tubeCamera(160, 192, c.azimuth, c.distanceM);
        const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(camera));
        for (TestVulkan* vulkan : {&precise, &byte}) {
            auto id = vulkan->renderer->addAvatar(avatar);
            ASSERT_TRUE(id) << id.error().message;
            const RenderedView image = drawOne(*vulkan->renderer, *id, pose, camera, true);
            const Difference d = compare(image, want);
            const bool isPrecise = vulkan == &precise;
            std::printf("[  IMAGE   ] %-10s %s %u splats: colour %.1f dB (max %.4f), alpha %.1f dB, depth max %.5f m, covered %.1f %%\n", c.name, isPrecise ? "f16  " : "8 bit",
                        avatar->splats.count(), d.psnrDb, d.maxError, d.alphaPsnrDb, d.maxDepthErrorM, d.covered * 100);
            dumpPicture(c.name, image);
            EXPECT_GT(d.covered, 0.005) << c.name;
            EXPECT_GE(d.psnrDb, isPrecise ? kMinPsnrDb : kMinBytePsnrDb) << c.name;
            EXPECT_GE(d.alphaPsnrDb, isPrecise ? kMinPsnrDb : kMinBytePsnrDb) << c.name;
            EXPECT_LT(d.maxDepthErrorM, 0.02) << c.name;  // a splat at the 1/255 cut-off may flip; it moves depth by α times the tube's thickness
            vulkan->renderer->removeAvatar(*id);
        }
    }
}

/** The tube drawn at a share of the size at which it is said to have been trained. */
TEST_P(VulkanImage, fourSamplesAPixelEqualTheReference) {
    TestVulkan precise(withPreciseBlending(), GetParam()), byte(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(precise);
    for (const float size : {0.5f, 0.25f}) {
        for (uint32_t seed = 1; seed <= 3; ++seed) {
            const Cameraf trained = tubeCamera(320, 384, 0.7f * float(seed), 1.8f), camera = trained.scaled(size);
            AvatarData data = makeTube({.shDegree = seed, .seed = seed});
            const Pose pose = tubePose(0.4f * float(seed), 0.3f);
            const ReferenceImage one = renderReference(data, pose, referenceCamera(camera));
            data.trainedPixelM = pixelAtM(trained, rootPosition(data.joints, pose));
            const auto avatar = share(data);
            const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(camera));
            EXPECT_LT(compareImages(one.rgb, want.rgb).psnrDb, 45) << "one sample shows the same: this case shows nothing";
            for (TestVulkan* vulkan : {&precise, &byte}) {
                auto id = vulkan->renderer->addAvatar(avatar);
                ASSERT_TRUE(id) << id.error().message;
                const RenderedView image = drawOne(*vulkan->renderer, *id, pose, camera, true);
                const Difference d = compare(image, want);
                const bool isPrecise = vulkan == &precise;
                std::printf("[  IMAGE   ] 4 samples, x%.2f, %u %s: colour %.1f dB (max %.4f), alpha %.1f dB, depth max %.5f m, covered %.1f %%\n", double(size), seed, isPrecise ? "f16  " : "8 bit",
                            d.psnrDb, d.maxError, d.alphaPsnrDb, d.maxDepthErrorM, d.covered * 100);
                EXPECT_GT(d.covered, 0.005);
                EXPECT_GE(d.psnrDb, kMinPsnrDb);  // in 8 bits too: four roundings average
                EXPECT_GE(d.alphaPsnrDb, kMinPsnrDb);
                EXPECT_LT(d.maxDepthErrorM, 0.02);
                EXPECT_TRUE(drawOne(*vulkan->renderer, *id, pose, camera).rgba == image.rgba) << "depth or not";
                vulkan->renderer->removeAvatar(*id);
            }
        }
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
        EXPECT_EQ(drawOne(*vulkan.renderer, *plain, pose, camera).rgba == drawOne(*vulkan.renderer, *sized, pose, camera).rgba, size > 0.8f) << size;
    }
}

TEST_P(VulkanImage, correctivesMoveAndLightTheSurfaceAsInTheReference) {
    TestVulkan precise(withPreciseBlending(), GetParam()), byte(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(precise);
    struct Case { const char* name; test::CorrectiveOptions correctives; uint32_t shDegree; float bend, turn; };
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
        EXPECT_LT(compareImages(renderReference(plain, pose, referenceCamera(camera)).rgb, want.rgb).psnrDb, 35) << c.name << ": this case shows nothing";
        for (const double l : referenceCorrection(*avatar, pose).light) darkest = std::min(darkest, l), brightest = std::max(brightest, l);
        for (TestVulkan* vulkan : {&precise, &byte}) {
            auto id = vulkan->renderer->addAvatar(avatar);
            ASSERT_TRUE(id) << id.error().message;
            const Difference d = compare(drawOne(*vulkan->renderer, *id, pose, camera, true), want);
            const bool isPrecise = vulkan == &precise;
            std::printf("[  IMAGE   ] correctives, %-9s %s: colour %.1f dB (max %.4f), alpha %.1f dB, depth max %.5f m\n", c.name, isPrecise ? "f16  " : "8 bit", d.psnrDb,
                        d.maxError, d.alphaPsnrDb, d.maxDepthErrorM);
            EXPECT_GE(d.psnrDb, isPrecise ? kMinPsnrDb : kMinBytePsnrDb) << c.name;
            EXPECT_GE(d.alphaPsnrDb, isPrecise ? kMinPsnrDb : kMinBytePsnrDb) << c.name;
            EXPECT_LT(d.maxDepthErrorM, 0.02) << c.name;
            vulkan->renderer->removeAvatar(*id);
        }
    }
    EXPECT_EQ(darkest, 0.2);
    EXPECT_EQ(brightest, 3.0);
}

TEST_P(VulkanImage, generalSplatsEqualTheReferenceAtEveryShDegree) {
    TestVulkan precise(withPreciseBlending(), GetParam()), byte(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(precise);
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        StaticSplatData splats = randomStaticSplats(degree + 1, 1500, degree);
        splats.compensated = degree % 2 == 1;   // as SPZ files may ask for
        const Cameraf camera = tubeCamera(160, 192, 0.7f, 2.2f);
        const ReferenceImage want = renderReference(splats, referenceCamera(camera), {.compensated = splats.compensated});
        const ReferenceImage other = renderReference(splats, referenceCamera(camera), {.compensated = !splats.compensated});
        EXPECT_LT(compareImages(other.rgb, want.rgb).psnrDb, 45) << "compensation shows nothing here";
        for (TestVulkan* vulkan : {&precise, &byte}) {
            auto id = vulkan->renderer->addSplats(splats);
            ASSERT_TRUE(id) << id.error().message;
            const Difference d = compare(drawOne(*vulkan->renderer, *id, {}, camera, true), want);
            const bool isPrecise = vulkan == &precise;
            std::printf("[  IMAGE   ] general, SH %u  %s: colour %.1f dB (max %.4f), alpha %.1f dB, depth max %.5f m, covered %.1f %%\n", degree, isPrecise ? "f16  " : "8 bit", d.psnrDb,
                        d.maxError, d.alphaPsnrDb, d.maxDepthErrorM, d.covered * 100);
            EXPECT_GT(d.covered, 0.05);
            EXPECT_GE(d.psnrDb, isPrecise ? kMinPsnrDb : kMinBytePsnrDb);
            EXPECT_GE(d.alphaPsnrDb, isPrecise ? kMinPsnrDb : kMinBytePsnrDb);
            EXPECT_LT(d.maxDepthErrorM, 0.05);   // splats lie up to 2 m behind each other: one at the 1/255 cut-off moves depth by its α times that
            vulkan->renderer->removeAvatar(*id);
        }
    }
}

/** A person-sized set in front of a wall 800 m away: 16 bits of depth would put all of it on a few keys. */
TEST_P(VulkanImage, generalSplatsStaySortedInADeepScene) {
    TestVulkan precise(withPreciseBlending(), GetParam());
    DPL_NEED_VULKAN(precise);
    StaticSplatData splats = randomStaticSplats(11, 1500, 0);
    for (uint32_t i = 0; i < 100; ++i) {
        splats.position.emplace_back(float(i % 10) * 60 - 300, float(i / 10) * 60 - 300, -800);
        splats.rotation.emplace_back(1, 0, 0, 0), splats.scaleM.emplace_back(40, 40, 1), splats.opacity.push_back(0.7f);
        splats.sh.insert(splats.sh.end(), {0.3f * float(i % 3), 0.5f, -0.4f});
    }
    const Cameraf camera = tubeCamera(160, 160, 0, 2.2f);
    auto id = precise.renderer->addSplats(splats);
    ASSERT_TRUE(id) << id.error().message;
    const Difference d = compare(drawOne(*precise.renderer, *id, {}, camera), renderReference(splats, referenceCamera(camera)));
    std::printf("[  IMAGE   ] deep scene: colour %.1f dB (max %.4f)\n", d.psnrDb, d.maxError);
    EXPECT_GT(d.covered, 0.5);
    EXPECT_GE(d.psnrDb, kMinPsnrDb);
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

void expectStereoEqualsMono(TestVulkan& vulkan, const Result<RenderAvatarId>& id, const Pose& pose, const std::string& picture) {
    ASSERT_TRUE(id) << id.error().message;
    const Cameraf views[2] = {tubeCamera(160, 144, 0.3f, 1.2f, -0.032f), tubeCamera(160, 144, 0.3f, 1.2f, 0.032f)};
    std::vector<RenderedView> both(2);
    const Status status = vulkan.renderer->render(*id, pose, views, true, both);
    ASSERT_TRUE(status) << status.error().message;
    for (size_t v = 0; v < 2; ++v) {
        const RenderedView alone = drawOne(*vulkan.renderer, *id, pose, views[v], true);
        EXPECT_TRUE(both[v].rgba == alone.rgba) << "colour of view " << v;
        EXPECT_TRUE(both[v].depthM == alone.depthM) << "depth of view " << v;
        EXPECT_GT(coverage(alone.depthM, 0.0), 0.05);
    }
    EXPECT_FALSE(both[0].rgba == both[1].rgba);
    dumpPicture((picture + "_left").c_str(), both[0]);
    dumpPicture((picture + "_right").c_str(), both[1]);
}

/** For an avatar and for general splats. */
void expectStereoEqualsMono(const VulkanOptions& options, Fill fill, const std::string& picture) {
    TestVulkan vulkan(options, fill);
    DPL_NEED_VULKAN(vulkan);
    expectStereoEqualsMono(vulkan, vulkan.renderer->addAvatar(share(test::withCorrectives(makeTube(), 3))), tubePose(0.7f), picture);
    AvatarData fine = makeTube();
    fine.trainedPixelM = 1e-4f;
    if (crashesOnMoreThanBytes()) std::printf("[   NOTE   ] four samples a pixel are left out at this vector width\n");
    else expectStereoEqualsMono(vulkan, vulkan.renderer->addAvatar(share(fine)), tubePose(0.7f), picture + "_four_samples");
    expectStereoEqualsMono(vulkan, vulkan.renderer->addSplats(randomStaticSplats(7, 1500, 2)), {}, picture + "_general");
}

TEST_P(VulkanImage, twoViewsAtOnceEqualEachViewAloneByInstances) {
    VulkanOptions options = testVulkanOptions();
    options.forceInstanceSplit = true;
    expectStereoEqualsMono(options, GetParam(), "instances");
}

TEST_P(VulkanImage, twoViewsAtOnceEqualEachViewAloneByMultiview) {
    auto backend = createVulkanBackend(testVulkanOptions());
    if (!backend) GTEST_SKIP() << backend.error().message;
    if (!(*backend)->info().multiview) GTEST_SKIP() << "multiview is missing or worked around on " << (*backend)->info().name;
    expectStereoEqualsMono(testVulkanOptions(), GetParam(), "multiview");
}

/** Draws a pair whose axes are `degrees` apart; the worse eye's distance to the same eye alone, and the largest difference in levels. */
ImageDifference cantedPairAgainstAlone(TestVulkan& vulkan, float degrees) {
    // Neighbouring splats of a person have similar colours; unrelated ones would turn every swap into a full-contrast error.
    const auto id = vulkan.renderer->addAvatar(share(makeTube({.singleFace = false, .colourSpread = 0.2f})));
    EXPECT_TRUE(id) << id.error().message;
    const Pose pose = tubePose(0.4f);
    const float half = glm::radians(degrees) / 2;
    const Cameraf views[2] = {tubeCamera(160, 144, -half, 1.4f), tubeCamera(160, 144, half, 1.4f)};
    std::vector<RenderedView> both(2);
    const Status status = vulkan.renderer->render(*id, pose, views, false, both);
    EXPECT_TRUE(status) << status.error().message;
    const auto stats = vulkan.renderer->stats(*id);
    EXPECT_TRUE(stats);
    EXPECT_EQ(stats->views, 2u);
    EXPECT_GT(stats->splatsDrawn, 100u);
    ImageDifference worst{std::numeric_limits<double>::infinity(), 0, 0};
    for (int v = 0; v < 2; ++v) {
        const RenderedView alone = drawOne(*vulkan.renderer, *id, pose, views[v]);
        EXPECT_GT(std::count_if(alone.rgba.begin(), alone.rgba.end(), [](uint8_t x) { return x > 20; }), 1000);
        const ImageDifference d = compareImages(std::vector<double>(alone.rgba.begin(), alone.rgba.end()), std::vector<double>(both[size_t(v)].rgba.begin(), both[size_t(v)].rgba.end()));
        worst.psnrDb = std::min(worst.psnrDb, d.psnrDb + 20 * std::log10(255.0));
        worst.maxError = std::max(worst.maxError, d.maxError);
    }
    std::printf("[  CANTED  ] %.1f degrees: %.1f dB, %.0f levels to its own sort\n", degrees, worst.psnrDb, worst.maxError);
    return worst;
}

TEST_P(VulkanImage, eyesThatShareAnOrderStayCloseToTheirOwn) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    EXPECT_GE(cantedPairAgainstAlone(vulkan, 1.9f).psnrDb, 45.0);  // technical reference §16
}

TEST_P(VulkanImage, cantedEyesAreSortedEachForItself) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    for (const float degrees : {2.1f, 9.2f, 25.f, 120.f, 180.f}) EXPECT_EQ(cantedPairAgainstAlone(vulkan, degrees).maxError, 0) << degrees;
}

TEST_P(VulkanImage, hundredFramesAreByteIdentical) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    auto id = vulkan.renderer->addAvatar(share(makeTube()));
    ASSERT_TRUE(id) << id.error().message;
    const Cameraf camera = tubeCamera(96, 96, 0.5f);
    const RenderedView first = drawOne(*vulkan.renderer, *id, tubePose(0.6f), camera);
    for (int frame = 1; frame < 100; ++frame) {
        if (frame % 10 == 0) drawOne(*vulkan.renderer, *id, tubePose(0.01f * float(frame)), camera);  // another pose in between leaves nothing behind
        ASSERT_EQ(drawOne(*vulkan.renderer, *id, tubePose(0.6f), camera).rgba, first.rgba) << "frame " << frame;
    }
}

TEST_P(VulkanImage, framesInFlightDrawWhatFramesAloneDraw) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    auto first = vulkan.renderer->addAvatar(share(makeTube())), second = vulkan.renderer->addAvatar(share(test::withCorrectives(makeTube({.seed = 3}), 1)));
    ASSERT_TRUE(first && second);
    const Cameraf views[2] = {tubeCamera(96, 80, 0.5f, 1.8f, -0.03f), tubeCamera(96, 80, 0.5f, 1.8f, 0.03f)};
    const RenderedView alone = drawOne(*vulkan.renderer, *first, tubePose(0.7f), views[0]), other = drawOne(*vulkan.renderer, *second, tubePose(-0.4f), views[1], true);
    for (int frame = 0; frame < 12; ++frame) {  // four times round the ring, poses, avatars and shapes mixed, nothing waited for
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
    vulkan.renderer->removeAvatar(*first);  // while it is drawn
}

/** A view of part of the subject at (0, middle, 0): from near or far, past it, off-axis, with any lens. */
Cameraf randomView(std::mt19937& random, float middle) {
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto around = [&](float reach) { return reach * Vec3f(2 * uniform(random) - 1, 2 * uniform(random) - 1, 2 * uniform(random) - 1); };
    const Vec3f target = Vec3f(0, middle, 0) + around(0.4f);
    const float azimuth = 6.2831853f * uniform(random), distance = 0.35f + 1.6f * uniform(random);
    const Vec3f eye = target + distance * Vec3f(std::sin(azimuth), 0.6f * uniform(random) - 0.3f, std::cos(azimuth));
    Cameraf c = lookAt(eye, target, 140, 112, 70 + 400 * uniform(random) * uniform(random));
    c.cx += 60 * (uniform(random) - 0.5f), c.cy += 60 * (uniform(random) - 0.5f);
    return c;
}

// Culling only leaves out what no view shows: the same bytes with and without it, and the referee's picture.
TEST_P(VulkanImage, cullingLosesNoVisibleSplat) {
    VulkanOptions options = withPreciseBlendingOfAnyWidth(), without = withPreciseBlendingOfAnyWidth();
    without.cullTriangles = false;
    TestVulkan culling(options, GetParam()), projectingAll(without, GetParam());
    DPL_NEED_VULKAN(culling);
    const double minPsnrDb = options.preciseBlending ? kMinPsnrDb : kMinBytePsnrDb;
    std::mt19937 random(5);
    uint64_t splats = 0, inView = 0, facing = 0, drawn = 0, chunks = 0, projected = 0;
    double worstDb = 1000;
    for (int round = 0; round < 12; ++round) {
        const bool blob = round % 2 == 0;
        AvatarData data = blob ? randomAvatar(uint32_t(round) + 1, 8, 4, 1) : test::withCorrectives(makeTube({.shDegree = 1, .colourSpread = 0.3f}), uint32_t(round));
        if (blob) for (float& c : data.splats.sh) c *= 0.3f;  // neighbours of a person agree; ties of the 16-bit key are not what this test is about
        const auto avatar = share(std::move(data));
        const Pose pose = blob ? randomPose(*avatar, uint32_t(round)) : tubePose(1.5f * std::sin(float(round)), float(round));
        const Cameraf first = randomView(random, blob ? 1 : 0.5f);
        Cameraf second = first;
        second.viewFromWorldTranslation.x -= 0.06f;
        const Cameraf views[2] = {first, second};
        const size_t viewCount = round % 3 == 0 ? 2 : 1;
        std::vector<RenderedView> culled(viewCount), all(viewCount);
        auto id = culling.renderer->addAvatar(avatar), allId = projectingAll.renderer->addAvatar(avatar);
        ASSERT_TRUE(id && allId);
        ASSERT_TRUE(culling.renderer->render(*id, pose, {views, viewCount}, true, culled));
        ASSERT_TRUE(projectingAll.renderer->render(*allId, pose, {views, viewCount}, true, all));
        auto stats = culling.renderer->stats(*id), allStats = projectingAll.renderer->stats(*allId);
        ASSERT_TRUE(stats && allStats);
        EXPECT_EQ(stats->splatsDrawn, allStats->splatsDrawn) << "round " << round;
        EXPECT_LE(stats->splatsDrawn, stats->splatsFacing);
        EXPECT_LE(stats->splatsFacing, stats->splatsInView);
        EXPECT_LE(stats->splatsFacing, stats->chunksProjected * gpu::kSplatGroup);
        EXPECT_EQ(allStats->chunksProjected, allStats->chunks);
        chunks += stats->chunks, projected += stats->chunksProjected;
        splats += avatar->splats.count(), inView += stats->splatsInView, facing += stats->splatsFacing, drawn += stats->splatsDrawn;
        for (size_t v = 0; v < viewCount; ++v) {
            EXPECT_TRUE(culled[v].rgba == all[v].rgba && culled[v].depthM == all[v].depthM) << "round " << round << ", view " << v;
            const Difference d = compare(culled[v], renderReference(*avatar, pose, referenceCamera(views[v])));
            worstDb = std::min({worstDb, d.psnrDb, d.alphaPsnrDb});
            EXPECT_GE(d.psnrDb, minPsnrDb) << "round " << round << ", view " << v;
            EXPECT_GE(d.alphaPsnrDb, minPsnrDb) << "round " << round << ", view " << v;
        }
        culling.renderer->removeAvatar(*id);
        projectingAll.renderer->removeAvatar(*allId);
    }
    std::printf("[ SURVIVORS] %llu splats, %llu in view, %llu facing, %llu drawn; worst %.1f dB\n", static_cast<unsigned long long>(splats), static_cast<unsigned long long>(inView),
                static_cast<unsigned long long>(facing), static_cast<unsigned long long>(drawn), worstDb);
    EXPECT_LT(projected, chunks * 9 / 10);
    EXPECT_LT(inView, splats * 9 / 10);
    EXPECT_LT(facing, inView * 9 / 10);
    EXPECT_GT(drawn, splats / 20);
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

// Lists cannot overflow: each has one entry a splat (docs/adr/0002). The worst case is a frame in which every splat is seen by every view, at
// counts that fill the blocks of compaction and sort exactly, and one more or less.
TEST_P(VulkanImage, everyListHoldsAFrameThatShowsEverySplat) {
    const VulkanOptions options = withPreciseBlendingOfAnyWidth();
    TestVulkan vulkan(options, GetParam());
    DPL_NEED_VULKAN(vulkan);
    const Cameraf views[2] = {tubeCamera(160, 144, 0.3f, 1.6f, -0.03f), tubeCamera(160, 144, 0.3f, 1.6f, 0.03f)};
    for (const uint32_t count : {gpu::kSortBlock - 1, gpu::kSortBlock, gpu::kSortBlock + 1, 2 * gpu::kSortBlock, gpu::kCompactBlock + 1, 1u}) {
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
                EXPECT_GE(d.psnrDb, options.preciseBlending ? kMinPsnrDb : kMinBytePsnrDb) << count << " splats, view " << v << " of " << viewCount;
            }
        }
        vulkan.renderer->removeAvatar(*id);
    }
}

/** Splats of half a metre seen from inside. Few of them overflow the list of entries, more of them that of spans already. */
TEST(VulkanTiles, aFrameThatTheListsCannotHoldIsFilledByQuads) {
    TestVulkan tiles(testVulkanOptions(), Fill::Tiles), quads(testVulkanOptions(), Fill::Quads);
    DPL_NEED_VULKAN(tiles);
    const Cameraf far[2] = {tubeCamera(61, 45, 0.3f, 40, -0.03f), tubeCamera(61, 45, 0.3f, 40, 0.03f)};
    const Cameraf near[2] = {tubeCamera(61, 45, 0.3f, 1.2f, -0.03f), tubeCamera(61, 45, 0.3f, 1.2f, 0.03f)};
    for (const uint32_t count : {400u, 1500u}) {
        const StaticSplatData splats = randomStaticSplats(3, count, 0, 0.5f);
        auto id = tiles.renderer->addSplats(splats), other = quads.renderer->addSplats(splats);
        ASSERT_TRUE(id && other);
        for (const size_t viewCount : {size_t(1), size_t(2)}) {
            for (const Cameraf* views : {far, near, far}) {  // back to tiles after an overflow
                std::vector<RenderedView> got(viewCount), want(viewCount);
                ASSERT_TRUE(tiles.renderer->render(*id, {}, {views, viewCount}, true, got));
                ASSERT_TRUE(quads.renderer->render(*other, {}, {views, viewCount}, true, want));
                auto stats = tiles.renderer->stats(*id);
                ASSERT_TRUE(stats);
                EXPECT_EQ(stats->tilesOverflowed, views == near) << count << " splats, " << viewCount << " views";
                if (views == near) { EXPECT_EQ(stats->tileEntries > 0, count == 400) << "entries are counted where the spans fit"; }
                for (size_t v = 0; v < viewCount; ++v) {
                    EXPECT_GT(coverage(want[v].depthM, 0.0), 0.001);
                    if (views != near) continue;  // the other tests compare tiles with the referee
                    EXPECT_TRUE(got[v].rgba == want[v].rgba && got[v].depthM == want[v].depthM) << count << " splats, view " << v << " of " << viewCount;
                }
            }
        }
        tiles.renderer->removeAvatar(*id);
        quads.renderer->removeAvatar(*other);
    }
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
    const Difference d = compare(drawOne(*vulkan.renderer, *oneId, tubePose(0.2f), camera), renderReference(one, tubePose(0.2f), referenceCamera(camera)));
    std::printf("[ ONE SPLAT] %.1f dB, max %.4f, covered %.2f %%\n", d.psnrDb, d.maxError, d.covered * 100);
    EXPECT_GE(d.psnrDb, kMinPsnrDb);
    EXPECT_GT(d.covered, 0.001);
    EXPECT_LE(d.maxError, 0.5 / 255 + 1e-4);  // one layer: rounding to 8 bits only
}

TEST_P(VulkanImage, onePixelTargetAndBehindTheCamera) {
    TestVulkan vulkan(withPreciseBlending(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const auto avatar = share(makeTube());
    auto id = vulkan.renderer->addAvatar(avatar);
    ASSERT_TRUE(id) << id.error().message;
    Cameraf one = tubeCamera(1, 1, 0);
    one.fx = one.fy = 4;
    const RenderedView pixel = drawOne(*vulkan.renderer, *id, tubePose(0), one, true);
    const ReferenceImage want = renderReference(*avatar, tubePose(0), referenceCamera(one));
    ASSERT_EQ(pixel.rgba.size(), 4u);
    EXPECT_NEAR(pixel.rgba[3] / 255.0, want.alpha[0], 0.01);  // 8 bits, and thousands of faint layers on one pixel, each rounded to f16
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
    EXPECT_EQ(times.size(), 1 + 2 + 2 + 2 + 4 + 12 + 3u + (GetParam() == Fill::Tiles ? 13u : 0u));
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
    EXPECT_EQ(status.error().code, Code::Unsupported);
    Cameraf nan = tubeCamera(16, 16, 0);
    nan.cx = NAN;
    EXPECT_FALSE(vulkan.renderer->render(*id, tubePose(0), {&nan, 1}, false, out));
    EXPECT_FALSE(vulkan.renderer->render(*id + 1, tubePose(0), {&huge, 1}, false, out));
    EXPECT_GT(drawOne(*vulkan.renderer, *id, tubePose(0), tubeCamera(32, 32, 0)).rgba.size(), 0u);  // still alive
}

}  // namespace
}  // namespace dpl
