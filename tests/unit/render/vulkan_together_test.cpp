// SPDX-License-Identifier: Apache-2.0
// Several avatars in one picture have one order of depth. The referee blends their splats as one set.
#include "tests/reference/random_avatar.h"
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

std::vector<ReferenceGaussian> gaussiansOf(const AvatarData& avatar, const Pose& pose) {
    std::vector<ReferenceGaussian> out;
    const ReferenceScene scene = sceneOf(avatar, pose);
    for (const ReferenceBoundSplat& s : scene.splats) {
        out.push_back(referenceGaussian(scene, s));
        out.back().shDegree = scene.shDegree;
    }
    return out;
}

std::vector<ReferenceGaussian> operator+(std::vector<ReferenceGaussian> a, const std::vector<ReferenceGaussian>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/** Two tubes of different SH degrees that pierce each other, and a cloud of general splats around them. */
struct Crowd {
    std::shared_ptr<const AvatarData> upright = share(makeTube()), lying = share(makeTube({.shDegree = 1, .seed = 9}));
    StaticSplatData cloud = randomStaticSplats(5, 400, 3);
    Pose uprightPose = tubePose(0.4f), lyingPose = tubePose(-0.3f);
    std::vector<ReferenceGaussian> gaussians;

    Crowd() {
        lyingPose.localRotations[0] = glm::angleAxis(1.5707963f, Vec3f(0, 0, 1));
        lyingPose.rootTranslation = Vec3f(0.5f, 0.45f, 0.03f);
        cloud.compensated = true;
        gaussians = gaussiansOf(*upright, uprightPose) + gaussiansOf(*lying, lyingPose);
        for (uint32_t i = 0; i < cloud.count(); ++i) gaussians.push_back(referenceGaussian(cloud, i));
    }
};

RenderedView drawSet(Renderer& r, std::span<const Drawn> what, std::span<const Cameraf> views, size_t view = 0) {
    const Status drawn = r.drawTogether(what, views, {});
    EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
    const auto pixels = r.read(what[0].avatar);
    EXPECT_TRUE(pixels) << (pixels ? "" : pixels.error().message);
    return {(*pixels)[view].widthPx, (*pixels)[view].heightPx, {(*pixels)[view].rgba.begin(), (*pixels)[view].rgba.end()}, {}, {}};
}

TEST_P(VulkanImage, avatarsThatPierceEachOtherAreSortedTogether) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const Crowd crowd;
    const auto a = vulkan.renderer->addAvatar(crowd.upright), b = vulkan.renderer->addAvatar(crowd.lying),
               c = vulkan.renderer->addSplats(crowd.cloud);
    ASSERT_TRUE(a && b && c);
    const Pose none;
    const Drawn set[3] = {{*a, &crowd.uprightPose}, {*b, &crowd.lyingPose}, {*c, &none}};
    const Cameraf views[2] = {tubeCamera(160, 144, 0.3f, 1.6f, -0.03f), tubeCamera(160, 144, 0.3f, 1.6f, 0.03f)};
    for (size_t viewCount : {1u, 2u}) {
        for (size_t v = 0; v < viewCount; ++v) {
            const RenderedView picture = drawSet(*vulkan.renderer, set, {views, viewCount}, v);
            const Difference d = compare(picture, renderReference(crowd.gaussians, referenceCamera(views[v])));
            std::printf("[  IMAGE   ] view %zu of %zu: colour %.1f dB (max %.4f), alpha %.1f dB, covered %.1f %%\n", v, viewCount, d.psnrDb,
                        d.maxError, d.alphaPsnrDb, 100 * d.covered);
            EXPECT_GE(d.psnrDb, kMinPsnrDb);
            EXPECT_GE(d.alphaPsnrDb, kMinPsnrDb);
            EXPECT_GT(d.covered, 0.15);
            dumpPicture(("together_" + std::to_string(v)).c_str(), picture);
        }
    }
    const auto stats = vulkan.renderer->stats(*a);
    ASSERT_TRUE(stats);
    EXPECT_EQ(stats->views, 2u);
    EXPECT_GT(stats->splatsDrawn, 4000u);
    EXPECT_GT(stats->chunksProjected, 20u);
    const auto notFirst = vulkan.renderer->read(*b);
    EXPECT_FALSE(notFirst) << "the picture is the first one's";

    // The case is hard: drawing one tube over the other gives another picture.
    const ReferenceCamera camera = referenceCamera(views[0]);
    const ReferenceImage near = renderReference(gaussiansOf(*crowd.upright, crowd.uprightPose), camera),
                         far = renderReference(gaussiansOf(*crowd.lying, crowd.lyingPose), camera),
                         both = renderReference(gaussiansOf(*crowd.upright, crowd.uprightPose) + gaussiansOf(*crowd.lying, crowd.lyingPose),
                                                camera);
    std::vector<double> over = near.rgb;
    for (size_t i = 0; i < over.size(); ++i) over[i] += (1 - near.alpha[i / 3]) * far.rgb[i];
    EXPECT_LT(compareImages(over, both.rgb).psnrDb, 35);
}

TEST_P(VulkanImage, depthKeysSpendNothingOnTheGapBetweenAvatars) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const auto avatar = share(makeTube());
    const auto near = vulkan.renderer->addAvatar(avatar), far = vulkan.renderer->addAvatar(avatar),
               behind = vulkan.renderer->addAvatar(avatar);
    ASSERT_TRUE(near && far && behind);
    const Cameraf camera = tubeCamera(160, 144, 0, 1.6f);
    Pose away[2] = {tubePose(0.2f), tubePose(0.2f)};
    away[0].rootTranslation = Vec3f(0.5f, 0, -2000);  // 16 bits over 2 km would be steps of 30 mm
    away[1].rootTranslation = Vec3f(0, 0, 2000);      // behind the camera
    const Pose pose = tubePose(0.5f);
    const ReferenceImage want = renderReference(*avatar, pose, referenceCamera(camera));
    const Drawn alone[1] = {{*near, &pose}}, set[3] = {{*far, &away[0]}, {*near, &pose}, {*behind, &away[1]}};
    const Difference d = compare(drawSet(*vulkan.renderer, alone, {&camera, 1}), want),
                     together = compare(drawSet(*vulkan.renderer, set, {&camera, 1}), want);
    std::printf("[  IMAGE   ] alone %.1f dB, with one 2 km away and one 2 km behind the camera %.1f dB\n", d.psnrDb, together.psnrDb);
    EXPECT_GE(together.psnrDb, d.psnrDb - 4) << "three intervals of the same length share the keys: a third of them is left";
    EXPECT_GE(together.psnrDb, kMinPsnrDb);
}

TEST_P(VulkanImage, sceneSetsComeAndGoWithTheirAvatars) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const auto avatar = share(makeTube({.splatsPerTriangle = 2}));
    std::vector<RenderAvatarId> ids;
    for (int i = 0; i < 7; ++i) ids.push_back(*vulkan.renderer->addAvatar(avatar));
    const Cameraf camera = tubeCamera(64, 64, 0);
    std::vector<Pose> poses;
    for (size_t i = 0; i < ids.size(); ++i) poses.push_back(tubePose(0.1f * float(i))), poses[i].rootTranslation.x = 0.2f * float(i) - 0.6f;
    const auto setOf = [&](std::vector<size_t> members) {
        std::vector<Drawn> set;
        for (size_t i : members) set.push_back({ids[i], &poses[i]});
        return set;
    };
    const RenderedView first = drawSet(*vulkan.renderer, setOf({0, 1}), {&camera, 1});
    for (size_t i = 2; i < 7; ++i) drawSet(*vulkan.renderer, setOf({0, i}), {&camera, 1});  // more sets than are kept
    EXPECT_TRUE(drawSet(*vulkan.renderer, setOf({0, 1}), {&camera, 1}).rgba == first.rgba) << "a dropped set is made again";
    EXPECT_FALSE(drawSet(*vulkan.renderer, setOf({0}), {&camera, 1}).rgba == first.rgba);

    const auto refused = [&](const std::vector<Drawn>& set) {
        const Status status = vulkan.renderer->drawTogether(set, {&camera, 1}, {});
        return !status && status.error().code == Code::InvalidArgument;
    };
    EXPECT_TRUE(refused({}));
    EXPECT_TRUE(refused(setOf({0, 1, 0}))) << "an avatar has one pose";
    EXPECT_TRUE(refused(std::vector<Drawn>(17, Drawn{ids[0], &poses[0]})));
    const uint64_t before = vulkan.renderer->stats(ids[0])->residentBytes;
    vulkan.renderer->removeAvatar(ids[1]);
    EXPECT_LT(vulkan.renderer->stats(ids[0])->residentBytes, before);
    EXPECT_TRUE(refused(setOf({0, 1})));
    drawSet(*vulkan.renderer, setOf({0, 2}), {&camera, 1});
}

}  // namespace
}  // namespace dpl
