// SPDX-License-Identifier: Apache-2.0
// The MSL kernel that fills tiles behind an app's scene and with four samples a pixel, on the CPU, against the referee.
#include <gtest/gtest.h>

#include <algorithm>

#include "apps/reference/reference_renderer.h"
#include "sdk/math/scene_depth.h"
#include "tests/metal/msl_frame.h"
#include "tests/reference/image_compare.h"
#include "tests/reference/random_scene_depth.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

TEST(MetalTiles, tilesBehindASceneMatchTheReference) {
    const AvatarData avatar = codedOnce(makeTube({.splatsPerTriangle = 4, .shDegree = 3}));
    const Pose pose = tubePose(0.9f, 0.4f);
    const Cameraf views[2] = {tubeCamera(93, 91, 0.6f, 1.6f, -0.03f), tubeCamera(93, 91, 0.6f, 1.6f, 0.03f)};
    const std::vector<float> scenes[2] = {randomSceneDepth(1, 93, 91, 1.6f), randomSceneDepth(2, 93, 91, 1.6f)};
    std::vector<float> seen;
    for (const auto& scene : scenes) std::transform(scene.begin(), scene.end(), std::back_inserter(seen), farthestSeenM);
    std::vector<uint32_t> first;
    for (int order = 0; order < 3; ++order) {
        MslFrame f = runFrame(avatar, pose, views, order), free = f;
        const std::vector<uint32_t> pixels = fillTiles(f, views, order, seen);
        if (order == 0) first = pixels;
        EXPECT_TRUE(pixels == first) << "lane order " << order;
        const std::vector<uint32_t> plain = fillTiles(free, views, order);
        free = runFrame(avatar, pose, views, order);
        const std::vector<uint32_t> empty = fillTiles(free, views, order, std::vector<float>(seen.size(), INFINITY));
        EXPECT_TRUE(std::equal(plain.begin(), plain.end(), empty.begin())) << "an empty scene changes nothing";
    }
    for (size_t v = 0; v < 2; ++v) {
        const ReferenceImage want = renderReference(avatar, pose, referenceCamera(views[v]), scenes[v]);
        EXPECT_LT(compareImages(renderReference(avatar, pose, referenceCamera(views[v])).rgb, want.rgb).psnrDb, 30)
            << "the scene hides nothing: this case would prove nothing";
        const ImageDifference d = compareImages(rgbOfView(first, views[v], v), want.rgb);
        std::printf("[   MSL    ] view %zu behind a scene: %.1f dB to the reference, max %.4f\n", v, d.psnrDb, d.maxError);
        EXPECT_GE(d.psnrDb, 50);
    }
}

TEST(MetalTiles, tilesOfFourSamplesMatchTheReferenceFreeAndBehindAScene) {
    AvatarData data = makeTube({.splatsPerTriangle = 4, .shDegree = 3});
    data.trainedPixelM = 1e-4f, data.kappaPx2 = 1 / 12.0f;
    const AvatarData avatar = codedOnce(data);
    const Pose pose = tubePose(0.9f, 0.4f);
    const Cameraf views[2] = {tubeCamera(93, 91, 0.6f, 1.6f, -0.03f), tubeCamera(93, 91, 0.6f, 1.6f, 0.03f)};
    ASSERT_TRUE(referenceFourSamples(avatar, pose, referenceCamera(views[0])));
    const std::vector<float> scenes[2] = {randomSceneDepth(1, 93, 91, 1.6f), randomSceneDepth(2, 93, 91, 1.6f)};
    std::vector<float> seen;
    for (const auto& scene : scenes) std::transform(scene.begin(), scene.end(), std::back_inserter(seen), farthestSeenM);
    for (const bool behind : {false, true}) {
        std::vector<uint32_t> first;
        for (int order = 0; order < 3; ++order) {
            MslFrame f = runFrame(avatar, pose, views, order, {}, 4);
            const std::vector<uint32_t> pixels =
                fillTiles(f, views, order, behind ? std::span<const float>(seen) : std::span<const float>(), 4);
            if (order == 0) first = pixels;
            EXPECT_TRUE(pixels == first) << "lane order " << order;
        }
        for (size_t v = 0; v < 2; ++v) {
            const ReferenceImage want = renderReference(avatar, pose, referenceCamera(views[v]), behind ? scenes[v] : std::vector<float>());
            const ImageDifference d = compareImages(rgbOfView(first, views[v], v), want.rgb);
            std::printf("[   MSL    ] view %zu, four samples%s: %.1f dB to the reference, max %.4f\n", v, behind ? " behind a scene" : "",
                        d.psnrDb, d.maxError);
            EXPECT_GE(d.psnrDb, 50);
            EXPECT_GT(coverage(want.alpha), 0.05);
        }
    }
}

}  // namespace
}  // namespace dpl
