// SPDX-License-Identifier: Apache-2.0
// Level of detail on Vulkan: agrees with the referee at any level, gives both eyes the same splats, and does not pop as a camera moves
// away.
#include "apps/reference/reference_detail.h"
#include "sdk/format/splat_detail.h"
#include "tests/reference/random_avatar.h"
#include "tests/reference/splat_room.h"
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

/** 20,000 splats, so that a group covers a patch of a few centimetres. */
struct Subject {
    std::shared_ptr<const AvatarData> avatar = [] {
        AvatarData tube = makeTube({.splatsPerTriangle = 16, .colourSpread = 0.4f});
        tube.joints[1].humanoidBone = "head";  // level of detail keeps more splats of its upper half
        return share(std::move(tube));
    }();
    CodedSplats coded = *codeSplats(avatar->mesh, avatar->splats);
    Subject() { measureDetail(*avatar, coded); }
};

ReferenceImage reducedReference(const Subject& s, const Pose& pose, const Cameraf& camera, double perPixel) {
    const double pixelM = referenceFinestPixelM(*s.avatar, pose, {referenceCamera(camera)});
    ReferenceScene scene = sceneOf(*s.avatar, pose);
    if (perPixel > 0) reduceReference(scene, *s.avatar, s.coded, perPixel / (pixelM * pixelM));
    return renderReference(scene, referenceCamera(camera), {.kappaPx2 = s.avatar->kappaPx2, .compensated = s.avatar->compensated});
}

TEST_P(VulkanImage, levelOfDetailAgreesWithTheReferee) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const Subject s;
    const auto id = vulkan.renderer->addAvatar(s.avatar);
    ASSERT_TRUE(id) << id.error().message;
    const Pose pose = tubePose(0.7f, 0.3f);
    uint32_t before = ~0u;
    for (const double perPixel : {0.5, 0.35, 0.2, 0.08, 0.01}) {
        const Cameraf camera = tubeCamera(160, 176, 0.5f, 2.2f);
        vulkan.renderer->setDetail({float(perPixel), 0});
        const RenderedView picture = drawOne(*vulkan.renderer, *id, pose, camera);
        const ReferenceImage want = reducedReference(s, pose, camera, perPixel);
        const Difference d = compare(picture, want), all = compare(picture, reducedReference(s, pose, camera, 0));
        const auto stats = vulkan.renderer->stats(*id);
        ASSERT_TRUE(stats);
        std::printf(
            "[  IMAGE   ] %4.2f splats a pixel, %5u drawn of %5.1f %%: colour %.1f dB (max %.4f), alpha %.1f dB; against all splats %.1f "
            "dB\n",
            perPixel, stats->splatsDrawn, 100 * double(stats->detailShare), d.psnrDb, d.maxError, d.alphaPsnrDb, all.psnrDb);
        EXPECT_GE(d.psnrDb, kMinPsnrDb);
        EXPECT_GE(d.alphaPsnrDb, kMinPsnrDb);
        EXPECT_LT(all.psnrDb, d.psnrDb) << "nothing was left out";
        EXPECT_LE(stats->splatsDrawn, stats->splatsAllowed);
        EXPECT_LT(stats->splatsDrawn, before);
        before = stats->splatsDrawn;
    }
}

TEST_P(VulkanImage, nearbyAndWithoutTheBytesAreTheSame) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const Subject s;
    const auto id = vulkan.renderer->addAvatar(s.avatar);
    ASSERT_TRUE(id) << id.error().message;
    const Cameraf camera = tubeCamera(160, 176, 0.5f, 1.4f);
    const Pose pose = tubePose(0.7f);
    const std::vector<uint8_t> without = drawOne(*vulkan.renderer, *id, pose, camera).rgba;
    vulkan.renderer->setDetail({4000, 0});
    EXPECT_TRUE(drawOne(*vulkan.renderer, *id, pose, camera).rgba == without);
    EXPECT_EQ(vulkan.renderer->stats(*id)->detailShare, 1);
    vulkan.renderer->setDetail({0, 2000});
    EXPECT_FALSE(drawOne(*vulkan.renderer, *id, pose, camera).rgba == without);
    const auto stats = vulkan.renderer->stats(*id);
    EXPECT_LE(stats->splatsAllowed, 2000u);
    EXPECT_LE(stats->splatsDrawn, 2000u);
    vulkan.renderer->setDetail({});
    EXPECT_TRUE(drawOne(*vulkan.renderer, *id, pose, camera).rgba == without);
}

/** Both eyes are drawn at the density that the finer eye needs. One eye alone at that density draws the same picture. */
TEST_P(VulkanImage, bothEyesShowTheSameSplats) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const Subject s;
    const auto id = vulkan.renderer->addAvatar(s.avatar);
    ASSERT_TRUE(id) << id.error().message;
    const Pose pose = tubePose(0.5f);
    const Cameraf near = tubeCamera(128, 144, 0.3f, 2.0f), far = tubeCamera(128, 144, 0.3f, 2.6f), pair[2] = {far, near};
    const auto pixelM = [&](const Cameraf& c) { return referenceFinestPixelM(*s.avatar, pose, {referenceCamera(c)}); };
    constexpr float kPerPixel = 0.25f;
    vulkan.renderer->setDetail({kPerPixel, 0});
    std::vector<RenderedView> both(2);
    ASSERT_TRUE(vulkan.renderer->render(*id, pose, pair, {}, both));
    EXPECT_TRUE(both[1].rgba == drawOne(*vulkan.renderer, *id, pose, near).rgba ||
                compare(both[1], reducedReference(s, pose, near, kPerPixel)).psnrDb > kMinPsnrDb);
    const std::vector<uint8_t> coarser = drawOne(*vulkan.renderer, *id, pose, far).rgba;
    const double ratio = pixelM(far) / pixelM(near);
    ASSERT_GT(ratio, 1.2);
    vulkan.renderer->setDetail({float(kPerPixel * ratio * ratio), 0});
    const RenderedView alone = drawOne(*vulkan.renderer, *id, pose, far);
    std::vector<double> a, b, c;
    for (size_t i = 0; i < alone.rgba.size(); ++i)
        a.push_back(alone.rgba[i] / 255.0), b.push_back(both[0].rgba[i] / 255.0), c.push_back(coarser[i] / 255.0);
    EXPECT_GT(compareImages(a, b).psnrDb, 60) << "the far eye of the pair is not drawn at the density of the near eye";
    EXPECT_LT(compareImages(c, b).psnrDb, 50) << "the densities give the same picture, so this case tests nothing";
}

/** Second differences over time of 8-bit values, as in vulkan_flicker_test. */
struct Pops {
    double mean = 0, largest = 0;
};
Pops popsOf(const std::vector<std::vector<float>>& frames) {
    Pops p;
    size_t count = 0;
    for (size_t t = 1; t + 1 < frames.size(); ++t)
        for (size_t i = 0; i < frames[t].size(); ++i) {
            const double change = std::abs(double(frames[t - 1][i]) - 2.0 * double(frames[t][i]) + double(frames[t + 1][i]));
            p.mean += change, p.largest = std::max(p.largest, change), count += frames[t][i] != 0;
        }
    p.mean /= double(std::max<size_t>(1, count));
    return p;
}

TEST_P(VulkanImage, nothingPopsWhileTheCameraWalksAway) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const Subject s;
    const auto id = vulkan.renderer->addAvatar(s.avatar);
    ASSERT_TRUE(id) << id.error().message;
    const Pose pose = tubePose(0.6f);
    // 0.43 m/s at 72 Hz. `taken` is the part of the picture that level of detail removes. It is measured by itself too, because the
    // motion of the camera changes everything else.
    std::vector<std::vector<float>> full, reduced, taken;
    float firstShare = 0, lastShare = 0, largestStep = 0;
    for (int t = 0; t < 60; ++t) {
        const Cameraf camera = tubeCamera(120, 128, 0.4f, 1.55f + 0.006f * float(t));
        vulkan.renderer->setDetail({});
        const std::vector<uint8_t> all = drawOne(*vulkan.renderer, *id, pose, camera).rgba;
        vulkan.renderer->setDetail({0.25f, 0});
        const std::vector<uint8_t> some = drawOne(*vulkan.renderer, *id, pose, camera).rgba;
        full.emplace_back(all.begin(), all.end()), reduced.emplace_back(some.begin(), some.end()), taken.emplace_back(all.size());
        for (size_t i = 0; i < all.size(); ++i) taken.back()[i] = float(all[i]) - float(some[i]);
        for (size_t i = 0; i < all.size() && t > 0; ++i)
            largestStep = std::max(largestStep, std::abs(taken[size_t(t)][i] - taken[size_t(t) - 1][i]));
        lastShare = vulkan.renderer->stats(*id)->detailShare;
        if (t == 0) firstShare = lastShare;
    }
    const Pops without = popsOf(full), with = popsOf(reduced), difference = popsOf(taken);
    std::printf(
        "[ FLICKER  ] share %.2f to %.2f; a covered value: %.4f levels (all splats %.4f), largest %.0f (%.0f); of what was taken away "
        "%.4f, largest %.0f, largest step %.0f\n",
        double(firstShare), double(lastShare), with.mean, without.mean, with.largest, without.largest, difference.mean, difference.largest,
        double(largestStep));
    EXPECT_GT(firstShare, 0.7f);
    EXPECT_LT(lastShare, 0.6f);
    EXPECT_LE(with.mean, 1.05 * without.mean);
    EXPECT_LE(with.largest, without.largest + 8);
}

Cameraf roomCamera(float aside = 0, float forward = 0, float turnRad = 0) {
    return lookAt({0.3f + aside, 0.2f, 3 - forward}, {3 * turnRad, 0, -8}, 150, 130, 110);
}

TEST_P(VulkanImage, levelOfDetailOfGeneralSplatsAgreesWithTheReferee) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const StaticSplatData room = splatRoom(1, 9005, 3);
    const auto id = vulkan.renderer->addSplats(room);
    ASSERT_TRUE(id) << id.error().message;
    const Cameraf camera = roomCamera();
    const ReferenceImage all = renderReference(room, referenceCamera(camera));
    const std::vector<uint8_t> without = drawOne(*vulkan.renderer, *id, {}, camera).rgba;
    uint32_t before = ~0u;
    for (const float perPixel : {1e6f, 0.2f, 0.06f, 0.02f, 0.003f}) {
        vulkan.renderer->setDetail({perPixel, 0});
        const RenderedView picture = drawOne(*vulkan.renderer, *id, {}, camera);
        const auto stats = vulkan.renderer->stats(*id);
        ASSERT_TRUE(stats);
        EXPECT_LE(stats->splatsDrawn, stats->splatsAllowed);
        EXPECT_LT(stats->splatsDrawn, before);
        before = stats->splatsDrawn;
        if (perPixel > 1) {
            EXPECT_TRUE(picture.rgba == without);
            EXPECT_EQ(stats->detailShare, 1);
            continue;
        }
        const ReferenceImage want =
            renderReference(reducedSplats(room, {camera}, double(perPixel)), referenceCamera(camera), {.compensated = false});
        const Difference d = compare(picture, want), toAll = compare(picture, all);
        std::printf(
            "[  IMAGE   ] room, %5.3f splats a pixel, %5u drawn of %5.1f %%: colour %.1f dB (max %.4f); against all splats %.1f dB\n",
            double(perPixel), stats->splatsDrawn, 100 * double(stats->detailShare), d.psnrDb, d.maxError, toAll.psnrDb);
        EXPECT_GE(d.psnrDb, kMinPsnrDb);
        EXPECT_LT(toAll.psnrDb, d.psnrDb) << "nothing was left out";
    }
    vulkan.renderer->setDetail({});
    EXPECT_TRUE(drawOne(*vulkan.renderer, *id, {}, camera).rgba == without);
}

/** Also for eyes whose axes differ so much that each has its own frame: level of detail still looks at both. */
TEST_P(VulkanImage, bothEyesShowTheSameGeneralSplats) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const StaticSplatData room = splatRoom(2, 6000);
    const auto id = vulkan.renderer->addSplats(room);
    ASSERT_TRUE(id) << id.error().message;
    vulkan.renderer->setDetail({0.02f, 0});
    for (const float turnRad : {0.0f, 0.3f}) {
        const Cameraf pair[2] = {roomCamera(0, 0, -turnRad), roomCamera(0.06f, 0.8f, turnRad)};
        std::vector<RenderedView> both(2);
        ASSERT_TRUE(vulkan.renderer->render(*id, {}, pair, {}, both));
        for (int v = 0; v < 2; ++v) {
            const auto referee = [&](std::initializer_list<Cameraf> views) {
                return renderReference(reducedSplats(room, views, 0.02), referenceCamera(pair[v]), {.compensated = false});
            };
            const Difference together = compare(both[size_t(v)], referee({pair[0], pair[1]}));
            const Difference alone = compare(both[size_t(v)], referee({pair[v]}));
            std::printf("[  IMAGE   ] eye %d, turned %.1f: %.1f dB to what both want, %.1f dB to what it wants alone\n", v, double(turnRad),
                        together.psnrDb, alone.psnrDb);
            EXPECT_GE(together.psnrDb, kMinPsnrDb);
            if (v == 0) {
                EXPECT_LT(alone.psnrDb, kMinPsnrDb - 5) << "one eye alone needs the same splats, so this case tests nothing";
            }
        }
    }
}

TEST_P(VulkanImage, oneBudgetHoldsForAnAvatarAndGeneralSplats) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const Subject s;
    const StaticSplatData room = splatRoom(3, 9000);
    const auto person = vulkan.renderer->addAvatar(s.avatar), around = vulkan.renderer->addSplats(room);
    ASSERT_TRUE(person && around);
    const Pose pose = tubePose(0.4f);
    const Drawn what[2] = {{*around, nullptr}, {*person, &pose}};
    const Cameraf camera = roomCamera();
    float shares[2] = {1, 1};
    for (const uint32_t budget : {15000u, 4000u, 1000u}) {
        vulkan.renderer->setDetail({0, budget});
        ASSERT_TRUE(vulkan.renderer->drawTogether(what, {&camera, 1}, {}));
        ASSERT_TRUE(vulkan.renderer->read(*around));
        const auto stats = vulkan.renderer->stats(*around), other = vulkan.renderer->stats(*person);
        ASSERT_TRUE(stats && other);
        EXPECT_LE(stats->splatsAllowed, budget);
        EXPECT_GE(stats->splatsAllowed, budget * 95 / 100);
        EXPECT_LE(stats->splatsDrawn, budget);
        EXPECT_GT(stats->splatsDrawn, budget / 8);  // half of the room is behind the camera, and half of the tube faces away
        EXPECT_LE(stats->detailShare, shares[0]);
        EXPECT_LE(other->detailShare, shares[1]);
        shares[0] = stats->detailShare, shares[1] = other->detailShare;
    }
    EXPECT_LT(shares[0], 0.2f);
    EXPECT_LT(shares[1], 0.2f);
}

TEST_P(VulkanImage, nothingPopsWhileTheCameraWalksThroughARoom) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    const StaticSplatData room = splatRoom(4, 6000);
    const auto id = vulkan.renderer->addSplats(room);
    ASSERT_TRUE(id) << id.error().message;
    std::vector<std::vector<float>> full, reduced;
    float share = 1;
    for (int t = 0; t < 60; ++t) {
        const Cameraf camera = roomCamera(0, 0.012f * float(t), 0.002f * float(t));
        vulkan.renderer->setDetail({});
        const std::vector<uint8_t> all = drawOne(*vulkan.renderer, *id, {}, camera).rgba;
        vulkan.renderer->setDetail({0.006f, 0});
        const std::vector<uint8_t> some = drawOne(*vulkan.renderer, *id, {}, camera).rgba;
        full.emplace_back(all.begin(), all.end()), reduced.emplace_back(some.begin(), some.end());
        share = std::min(share, vulkan.renderer->stats(*id)->detailShare);
    }
    const Pops without = popsOf(full), with = popsOf(reduced);
    std::printf("[ FLICKER  ] room, share down to %.2f; a covered value: %.4f levels (all splats %.4f), largest %.0f (%.0f)\n",
                double(share), with.mean, without.mean, with.largest, without.largest);
    EXPECT_LT(share, 0.7f);
    EXPECT_LE(with.mean, 1.05 * without.mean);
    EXPECT_LE(with.largest, without.largest + 8);
}

}  // namespace
}  // namespace dpl
