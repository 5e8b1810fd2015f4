// SPDX-License-Identifier: Apache-2.0
// Kernels with typed buffers, and kernels whose lanes fetch records for each other, draw the same pictures as the plain kernels.
#include "sdk/backend/vulkan/vulkan_backend.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

/** Colour and depth of avatars and of general splats of these SH degrees, each alone and all in one picture, in one view and two, with and
 *  without a scene. Then two pictures with four samples a pixel. */
std::vector<RenderedView> everything(Renderer& r, const std::vector<uint32_t>& degrees) {
    std::vector<RenderedView> pictures;
    const Cameraf views[2] = {tubeCamera(150, 141, 0.3f, 1.5f, -0.03f), tubeCamera(150, 141, 0.3f, 1.5f, 0.03f)};
    const std::vector<float> scene(150 * 141, 1.5f);
    const auto draw = [&](std::span<const Drawn> set) {
        for (size_t viewCount : {1u, 2u}) {
            for (bool behind : {false, true}) {
                FrameWants wants(true);
                for (size_t v = 0; behind && v < viewCount; ++v) wants.sceneDepthM[v] = scene;
                const Status drawn = r.drawTogether(set, {views, viewCount}, wants);
                EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
                const auto pixels = r.read(set[0].avatar);
                EXPECT_TRUE(pixels) << (pixels ? "" : pixels.error().message);
                if (!pixels) return;
                for (const PixelView& p : *pixels)
                    pictures.push_back({p.widthPx, p.heightPx, {p.rgba.begin(), p.rgba.end()}, {p.depthM.begin(), p.depthM.end()}, {}});
            }
        }
    };
    const Pose pose = tubePose(0.4f), none;
    std::vector<Drawn> set;
    for (const uint32_t degree : degrees) {
        const auto id = r.addAvatar(share(makeTube({.shDegree = degree, .seed = 3 + degree})));
        EXPECT_TRUE(id);
        set.push_back({*id, &pose});
    }
    for (const uint32_t degree : degrees) {
        const auto id = r.addSplats(randomStaticSplats(5 + degree, 400, degree));
        EXPECT_TRUE(id);
        set.push_back({*id, &none});
    }
    for (const Drawn& one : set) draw({&one, 1});
    draw(set);
    AvatarData fine = makeTube({.seed = 17});
    fine.trainedPixelM = 1e-4f;
    const auto id = r.addAvatar(share(fine));
    EXPECT_TRUE(id);
    set.push_back({*id, &pose});
    draw({&set.back(), 1});
    draw({&set.back() - 1, 2});  // together with general splats
    return pictures;
}

void expectSamePictures(Renderer& a, Renderer& b, const std::vector<uint32_t>& degrees) {
    const auto want = everything(a, degrees), got = everything(b, degrees);
    ASSERT_EQ(want.size(), got.size());
    size_t covered = 0;
    for (size_t i = 0; i < want.size(); ++i) {
        EXPECT_TRUE(sameButForRounding(want[i].rgba, got[i].rgba)) << i;
        EXPECT_EQ(want[i].depthM, got[i].depthM) << i;
        for (size_t k = 3; k < want[i].rgba.size(); k += 4) covered += want[i].rgba[k] > 0;
    }
    EXPECT_GT(covered, want.size() * 500);
}

TEST_P(VulkanImage, typedBuffersGiveTheSamePictureAsPlainOnes) {
    VulkanTestOptions plain = testVulkanOptions(), typed = testVulkanOptions();
    plain.typedBuffers = false;
    typed.typedBuffers = true;
    TestVulkan a(plain, GetParam()), b(typed, GetParam());
    DPL_NEED_VULKAN(a);
    const auto backend = createTestBackend(typed);
    ASSERT_TRUE(backend);
    if (!(*backend)->info().texels) GTEST_SKIP() << (*backend)->info().name << " reads plain buffers";
    expectSamePictures(*a.renderer, *b.renderer, {0, 1, 2, 3});
}

TEST(VulkanTiles, lanesThatFetchForEachOtherGiveTheSamePictureAsLanesThatDoNot) {
    VulkanTestOptions alone = testVulkanOptions();
    alone.shuffle = false;
    TestVulkan a(alone, Fill::Tiles), b(testVulkanOptions(), Fill::Tiles);
    DPL_NEED_VULKAN(a);
    const auto backend = createTestBackend();
    ASSERT_TRUE(backend);
    if (!(*backend)->info().shuffle)
        GTEST_SKIP() << "subgroups of " << (*backend)->info().name << " do not hold whole tiles, or cannot shuffle";
    expectSamePictures(*a.renderer, *b.renderer, {1});
}

}  // namespace
}  // namespace dpl
