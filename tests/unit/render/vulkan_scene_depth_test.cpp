// SPDX-License-Identifier: Apache-2.0
// Splats behind the app's scene on Vulkan, drawn by quads and by tiles, against the referee.
#include "sdk/math/coverage.h"
#include "tests/reference/random_avatar.h"
#include "tests/reference/random_scene_depth.h"
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

class VulkanSceneDepth : public testing::TestWithParam<Fill> {};
INSTANTIATE_TEST_SUITE_P(Fill, VulkanSceneDepth, testing::Values(Fill::Quads, Fill::Tiles),
                         [](const auto& info) { return std::string(info.param == Fill::Tiles ? "VulkanTiles" : "Quads"); });

/** scenes: depths in metres for each view; empty: no scene. */
std::vector<RenderedView> drawBehind(Renderer& renderer, RenderAvatarId id, const Pose& pose, std::span<const Cameraf> views,
                                     const std::vector<std::vector<float>>& scenes, bool depth) {
    FrameWants wants(depth);
    for (size_t v = 0; v < scenes.size(); ++v) wants.sceneDepthM[v] = scenes[v];
    std::vector<RenderedView> out(views.size());
    const Status status = renderer.render(id, pose, views, wants, out);
    EXPECT_TRUE(status) << (status ? "" : status.error().message);
    return out;
}

void expectAgrees(const char* name, const RenderedView& image, const ReferenceImage& want) {
    const Difference d = compare(image, want);
    std::printf("[  SCENE   ] %-16s: colour %.1f dB (max %.4f), alpha %.1f dB, depth max %.5f m, covered %.1f %%\n", name, d.psnrDb,
                d.maxError, d.alphaPsnrDb, d.maxDepthErrorM, d.covered * 100);
    EXPECT_GE(d.psnrDb, kMinPsnrDb) << name;
    EXPECT_GE(d.alphaPsnrDb, kMinPsnrDb) << name;
    EXPECT_LT(d.maxDepthErrorM, 0.02) << name;
    EXPECT_GT(d.covered, 0.02) << name;
}

TEST_P(VulkanSceneDepth, equalsTheReferenceForOneViewAndTwo) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    for (uint32_t seed = 1; seed <= 3; ++seed) {
        const auto avatar = share(makeTube({.shDegree = 1, .seed = seed}));
        const Pose pose = tubePose(0.5f * float(seed), 0.3f);
        const Cameraf views[2] = {tubeCamera(97, 120, float(seed), 1.7f, -0.03f), tubeCamera(97, 120, float(seed), 1.7f, 0.03f)};
        const std::vector<std::vector<float>> scenes = {randomSceneDepth(seed, 97, 120, 1.7f), randomSceneDepth(seed + 10, 97, 120, 1.65f)};
        ReferenceImage want[2];
        for (size_t v = 0; v < 2; ++v) {
            want[v] = renderReference(*avatar, pose, referenceCamera(views[v]), scenes[v]);
            EXPECT_LT(compareImages(renderReference(*avatar, pose, referenceCamera(views[v])).rgb, want[v].rgb).psnrDb, 30)
                << "the scene hides nothing, so this case tests nothing";
        }
        auto id = vulkan.renderer->addAvatar(avatar);
        ASSERT_TRUE(id) << id.error().message;
        const auto pair = drawBehind(*vulkan.renderer, *id, pose, views, scenes, true);
        for (size_t v = 0; v < 2; ++v) {
            expectAgrees(v ? "pair, right" : "pair, left", pair[v], want[v]);
            EXPECT_TRUE(sameButForRounding(drawBehind(*vulkan.renderer, *id, pose, views, scenes, false)[v].rgba, pair[v].rgba))
                << "with depth or without";
        }
        EXPECT_TRUE(drawBehind(*vulkan.renderer, *id, pose, {views, 1}, {scenes[0]}, true)[0].rgba == pair[0].rgba) << "alone";
        // With a scene for the right eye only, the left eye's picture is the one without a scene.
        const auto right = drawBehind(*vulkan.renderer, *id, pose, views, {{}, scenes[1]}, false),
                   free = drawBehind(*vulkan.renderer, *id, pose, views, {}, false);
        EXPECT_TRUE(sameButForRounding(right[0].rgba, free[0].rgba));
        EXPECT_TRUE(sameButForRounding(right[1].rgba, pair[1].rgba));
        EXPECT_FALSE(free[1].rgba == pair[1].rgba);
        vulkan.renderer->removeAvatar(*id);
    }
}

TEST_P(VulkanSceneDepth, equalsTheReferenceWithFourSamplesAPixel) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_FOUR_SAMPLES(vulkan);
    const Cameraf trained = tubeCamera(320, 384, 0.7f, 1.8f), camera = trained.scaled(0.4f);
    AvatarData data = makeTube({.shDegree = 1});
    const Pose pose = tubePose(0.4f, 0.3f);
    data.trainedPixelM = pixelAtM(trained, rootPosition(data.joints, pose));
    const auto avatar = share(data);
    const std::vector<float> scene = randomSceneDepth(3, camera.widthPx, camera.heightPx, 1.8f);
    auto id = vulkan.renderer->addAvatar(avatar);
    ASSERT_TRUE(id) << id.error().message;
    ASSERT_TRUE(referenceFourSamples(*avatar, pose, referenceCamera(camera)));
    expectAgrees("four samples", drawBehind(*vulkan.renderer, *id, pose, {&camera, 1}, {scene}, true)[0],
                 renderReference(*avatar, pose, referenceCamera(camera), scene));
}

TEST_P(VulkanSceneDepth, aSceneWithNothingInItLeavesEveryByteAndOneInFrontNone) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    auto id = vulkan.renderer->addAvatar(share(makeTube()));
    ASSERT_TRUE(id) << id.error().message;
    for (const uint32_t side : {1u, 3u, 96u}) {
        const Cameraf camera = tubeCamera(side, side, 0.5f);
        const auto alone = drawBehind(*vulkan.renderer, *id, tubePose(0.5f), {&camera, 1}, {}, true)[0];
        for (const float nothing : {0.0f, -1.0f, INFINITY, NAN, 100.0f}) {
            const auto image =
                drawBehind(*vulkan.renderer, *id, tubePose(0.5f), {&camera, 1}, {std::vector<float>(side * side, nothing)}, true)[0];
            EXPECT_TRUE(image.rgba == alone.rgba && image.depthM == alone.depthM) << nothing << ", " << side << " px";
        }
        const auto hidden =
            drawBehind(*vulkan.renderer, *id, tubePose(0.5f), {&camera, 1}, {std::vector<float>(side * side, 0.06f)}, false)[0];
        EXPECT_EQ(*std::max_element(hidden.rgba.begin(), hidden.rgba.end()), 0);
    }
}

/** The splat lies on the camera's axis, so its depth is exactly 2. */
TEST_P(VulkanSceneDepth, equalDepthIsSeenAndTheNextFloatBeforeItHides) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    StaticSplatData splats = randomStaticSplats(1, 1, 0);
    splats.position = {{0, 0, 2}}, splats.scaleM = {{0.2f, 0.2f, 0.2f}}, splats.opacity = {0.9f};
    Cameraf camera;
    camera.widthPx = camera.heightPx = 33, camera.fx = camera.fy = 30, camera.cx = camera.cy = 16.5f;
    auto id = vulkan.renderer->addSplats(splats);
    ASSERT_TRUE(id) << id.error().message;
    std::vector<float> scene(33 * 33, 2.0f);
    for (size_t i = 0; i < scene.size(); i += 2) scene[i] = std::nextafter(2.0f, 0.0f);
    const RenderedView alone = drawBehind(*vulkan.renderer, *id, {}, {&camera, 1}, {}, false)[0],
                       image = drawBehind(*vulkan.renderer, *id, {}, {&camera, 1}, {scene}, false)[0];
    size_t seen = 0;
    for (size_t i = 0; i < scene.size(); ++i) {
        ASSERT_EQ(image.rgba[4 * i + 3], i % 2 ? alone.rgba[4 * i + 3] : 0) << i;
        seen += image.rgba[4 * i + 3] > 0;
    }
    EXPECT_GT(seen, 20u);
}

/** Many layers in few tiles overflow the lists, so each tile searches, with the scene of its slot. */
TEST_P(VulkanSceneDepth, holdsWhereTheListsOfTilesOverflowAndForGeneralSplats) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    for (const float sizeM : {0.02f, 1.0f}) {
        StaticSplatData splats = randomStaticSplats(4, sizeM > 0.5f ? 300 : 1500, 0, sizeM);
        const Cameraf camera = tubeCamera(120, 100, 0.7f, 2.2f);
        const std::vector<float> scene = randomSceneDepth(7, 120, 100, 2.2f);
        auto id = vulkan.renderer->addSplats(splats);
        ASSERT_TRUE(id) << id.error().message;
        const RenderedView image = drawBehind(*vulkan.renderer, *id, {}, {&camera, 1}, {scene}, false)[0];
        const Difference d = compare(image, renderReference(splats, referenceCamera(camera), {.compensated = false, .sceneDepthM = scene}));
        const auto stats = vulkan.renderer->stats(*id);
        ASSERT_TRUE(stats);
        std::printf("[  SCENE   ] %g m splats: colour %.1f dB, overflowed %d\n", double(sizeM), d.psnrDb, int(stats->tilesOverflowed));
        EXPECT_GE(d.psnrDb, kMinPsnrDb);
        EXPECT_GT(d.covered, 0.1);
        EXPECT_EQ(stats->tilesOverflowed, GetParam() == Fill::Tiles && sizeM > 0.5f);
        vulkan.renderer->removeAvatar(*id);
    }
}

TEST_P(VulkanSceneDepth, framesInFlightKeepTheirOwnScene) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    auto id = vulkan.renderer->addAvatar(share(makeTube()));
    ASSERT_TRUE(id) << id.error().message;
    const Cameraf camera = tubeCamera(96, 80, 0.5f);
    const std::vector<float> scene = randomSceneDepth(1, 96, 80, 1.8f);
    const RenderedView alone = drawBehind(*vulkan.renderer, *id, tubePose(0.7f), {&camera, 1}, {scene}, true)[0];
    for (uint32_t frame = 0; frame < 9; ++frame) {
        for (uint32_t later = 0; later < 4; ++later) {
            std::vector<float> kept = later == 3 ? scene : randomSceneDepth(frame + later + 2, 96, 80, 1.7f);
            FrameWants wants(true);
            wants.sceneDepthM[0] = kept;
            ASSERT_TRUE(vulkan.renderer->draw(*id, tubePose(later == 3 ? 0.7f : 0.1f * float(later)), {&camera, 1}, wants));
            std::fill(kept.begin(), kept.end(), 0.06f);  // the caller may reuse the memory as soon as draw() returns
        }
        auto pixels = vulkan.renderer->read(*id);
        ASSERT_TRUE(pixels) << pixels.error().message;
        EXPECT_TRUE(std::equal(alone.rgba.begin(), alone.rgba.end(), (*pixels)[0].rgba.begin()));
    }
    FrameWants wants;
    const std::vector<float> tooFew(96 * 80 - 1, 1.0f);
    wants.sceneDepthM[0] = tooFew;
    const Status refused = vulkan.renderer->draw(*id, tubePose(0), {&camera, 1}, wants);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::InvalidArgument);
}

}  // namespace
}  // namespace dpl
