// SPDX-License-Identifier: Apache-2.0
// Two views in one call give the pictures of each view alone: the same bytes with parallel axes or with an order of depth for each view,
// nearly the same where canted axes share an order.
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

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

/** Checks it for an avatar and for general splats. */
void expectStereoEqualsMono(const VulkanTestOptions& options, Fill fill, const std::string& picture) {
    TestVulkan vulkan(options, fill);
    DPL_NEED_VULKAN(vulkan);
    expectStereoEqualsMono(vulkan, vulkan.renderer->addAvatar(share(test::withCorrectives(makeTube(), 3))), tubePose(0.7f), picture);
    AvatarData fine = makeTube();
    fine.trainedPixelM = 1e-4f;
    expectStereoEqualsMono(vulkan, vulkan.renderer->addAvatar(share(fine)), tubePose(0.7f), picture + "_four_samples");
    expectStereoEqualsMono(vulkan, vulkan.renderer->addSplats(randomStaticSplats(7, 1500, 2)), {}, picture + "_general");
}

TEST_P(VulkanImage, twoViewsAtOnceEqualEachViewAloneByADrawEach) {
    VulkanTestOptions options = testVulkanOptions();
    options.withoutMultiview = true;
    expectStereoEqualsMono(options, GetParam(), "a_draw_each");
}

TEST_P(VulkanImage, twoViewsAtOnceEqualEachViewAloneByMultiview) {
    auto backend = createTestBackend();
    if (!backend) GTEST_SKIP() << backend.error().message;
    if (!(*backend)->info().multiview) GTEST_SKIP() << "multiview is missing or worked around on " << (*backend)->info().name;
    expectStereoEqualsMono(testVulkanOptions(), GetParam(), "multiview");
}

/** Draws a pair of eyes whose axes are `degrees` apart. Returns the difference of the worse eye from the same eye drawn alone. */
ImageDifference cantedPairAgainstAlone(TestVulkan& vulkan, float degrees) {
    // Neighbouring splats of a person have similar colours. With random colours every swap would be an error of full contrast.
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
        const ImageDifference d = compareImages(std::vector<double>(alone.rgba.begin(), alone.rgba.end()),
                                                std::vector<double>(both[size_t(v)].rgba.begin(), both[size_t(v)].rgba.end()));
        worst.psnrDb = std::min(worst.psnrDb, d.psnrDb + 20 * std::log10(255.0));
        worst.maxError = std::max(worst.maxError, d.maxError);
    }
    std::printf("[  CANTED  ] %.1f degrees: %.1f dB, %.0f levels to its own sort\n", degrees, worst.psnrDb, worst.maxError);
    return worst;
}

TEST_P(VulkanImage, eyesThatShareAnOrderStayCloseToTheirOwn) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    EXPECT_GE(cantedPairAgainstAlone(vulkan, 1.9f).psnrDb, 45.0);  // docs/reference/gpu-frame.md
}

TEST_P(VulkanImage, cantedEyesAreSortedEachForItself) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    for (const float degrees : {2.1f, 9.2f, 25.f, 120.f, 180.f}) EXPECT_EQ(cantedPairAgainstAlone(vulkan, degrees).maxError, 0) << degrees;
}

}  // namespace
}  // namespace dpl
