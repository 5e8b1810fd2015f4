// SPDX-License-Identifier: Apache-2.0
// The CPU engine's depth test against the app's scene, compared with the referee.
#include "tests/reference/compare_renderers.h"
#include "tests/reference/random_avatar.h"
#include "tests/reference/random_scene_depth.h"

namespace dpl {
namespace {

SplatImage drawBehind(const ReferenceScene& scene, const Cameraf& camera, std::span<const float> sceneDepthM, uint32_t samples = 1,
                      uint32_t threads = 2) {
    Jobs jobs(threads);
    SplatEngine engine(jobs);
    const EngineInput input(scene);
    SplatImage image;
    engine.project(PackedSplats(input.view()), input.frames, camera, float(kKappaPx2), true, samples);
    engine.bin();
    engine.blend(image, {.cloth = true, .depth = true, .sceneDepthM = sceneDepthM});
    return image;
}

TEST(SceneDepth, hidesWhatTheRefereeHides) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        for (const bool four : {false, true}) {
            const AvatarData avatar = randomAvatar(seed, 8, 4, seed % 4);
            const Cameraf camera =
                lookAt({1.7f * std::sin(float(seed)), 1, 1.7f * std::cos(float(seed))}, {0, 1, 0}, 101 + 7 * seed, 130 - 9 * seed, 110)
                    .scaled(four ? 0.5f : 1.0f);
            const ReferenceScene scene = sceneOf(avatar, randomPose(avatar, seed));
            ReferenceOptions options{.sceneDepthM = randomSceneDepth(seed, camera.widthPx, camera.heightPx, 1.7f), .fourSamples = four};
            const ReferenceImage want = renderReference(scene, referenceCamera(camera), options);
            const SplatImage image = drawBehind(scene, camera, options.sceneDepthM, four ? kCoverageSamples : 1);
            expectSameImage(("behind a scene, avatar " + std::to_string(seed) + (four ? ", four samples" : "")).c_str(), image, want,
                            kBarDb);
            EXPECT_GT(coverage(want.alpha), 0.05);
            options.sceneDepthM.clear();
            EXPECT_LT(compareImages(renderReference(scene, referenceCamera(camera), options).rgb, want.rgb).psnrDb, 30)
                << "the scene hides nothing, so this case tests nothing";
            EXPECT_EQ(
                drawBehind(scene, camera, randomSceneDepth(seed, camera.widthPx, camera.heightPx, 1.7f), four ? kCoverageSamples : 1, 3)
                    .rgb,
                image.rgb)
                << "on three threads";
        }
    }
}

TEST(SceneDepth, aSceneWithNothingInItLeavesEveryBit) {
    const AvatarData avatar = randomAvatar(5);
    const ReferenceScene scene = sceneOf(avatar, randomPose(avatar, 5));
    const Cameraf camera = lookAt({0.4f, 1, 1.8f}, {0, 1, 0}, 90, 77, 80);
    const SplatImage alone = drawSoftware(scene, camera);
    EXPECT_GT(coverage(alone.alpha), 0.1);
    const float inf = std::numeric_limits<float>::infinity();
    for (const float nothing : {0.0f, -0.0f, -3.0f, inf, -inf, std::numeric_limits<float>::quiet_NaN(), 1e9f}) {
        const SplatImage image = drawBehind(scene, camera, std::vector<float>(90 * 77, nothing));
        EXPECT_TRUE(image.rgb == alone.rgb && image.alpha == alone.alpha && image.cloth == alone.cloth && image.depthM == alone.depthM)
            << nothing;
    }
    const SplatImage hidden = drawBehind(scene, camera, std::vector<float>(90 * 77, 0.06f));
    EXPECT_EQ(*std::max_element(hidden.alpha.begin(), hidden.alpha.end()), 0.0f);
}

/** The camera looks along +z from the origin, so the splat's depth is exactly 2. */
TEST(SceneDepth, equalDepthIsSeenAndTheNextFloatBeforeItHides) {
    StaticSplatData s = randomStaticSplats(1, 1, 0);
    s.position = {{0, 0, 2}}, s.scaleM = {{0.2f, 0.2f, 0.2f}}, s.opacity = {0.9f};
    Cameraf camera;
    camera.widthPx = camera.heightPx = 33, camera.fx = camera.fy = 30, camera.cx = camera.cy = 16.5f;
    Jobs jobs(1);
    SplatEngine engine(jobs);
    SplatImage image;
    engine.project(s, camera, float(kKappaPx2));
    engine.bin();
    std::vector<float> scene(33 * 33, 2.0f);
    for (size_t i = 0; i < scene.size(); i += 2) scene[i] = std::nextafter(2.0f, 0.0f);
    engine.blend(image, {.sceneDepthM = scene});
    size_t seen = 0;
    for (size_t i = 0; i < scene.size(); ++i) {
        if (i % 2 == 0) {
            ASSERT_EQ(image.alpha[i], 0.0f);
        }
        seen += image.alpha[i] > 0.1f;
    }
    EXPECT_GT(seen, 20u);
    std::vector<uint8_t> rgba;
    std::vector<float> depthM;
    engine.blendRgba8(rgba, &depthM, scene);
    for (size_t i = 0; i < scene.size(); ++i) ASSERT_EQ(rgba[4 * i + 3] > 0, image.alpha[i] >= 0.5f / 255) << i;
    EXPECT_EQ(depthM[16 * 33 + 16], 0.0f) << "even: hidden";
    EXPECT_NEAR(depthM[16 * 33 + 17], 2.0f, 1e-5f);
}

}  // namespace
}  // namespace dpl
