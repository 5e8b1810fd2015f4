// SPDX-License-Identifier: Apache-2.0
// Several avatars in one picture through the public API: the fixture's red square, a second one, and general splats.
#include <algorithm>

#include "sdk/format/ply.h"
#include "tests/unit/api/api_fixture.h"

namespace dpl::test {
namespace {

class TogetherTest : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        const auto bytes = tinyFile();
        ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &other_), DPL_OK) << dplGetLastError();
        StaticSplatData green;
        green.position = {{0, 1, 0.2f}}, green.rotation = {{1, 0, 0, 0}}, green.scaleM = {{0.12f, 0.12f, 0.01f}}, green.opacity = {0.95f},
        green.sh = {-1.7f, 1.7f, -1.7f};
        const auto file = *writePly(green);
        ASSERT_EQ(dplLoadAvatar(context_, file.data(), file.size(), &green_), DPL_OK) << dplGetLastError();
    }
    void TearDown() override {
        EXPECT_EQ(dplDestroyAvatar(other_), DPL_OK);
        EXPECT_EQ(dplDestroyAvatar(green_), DPL_OK);
        ApiTest::TearDown();
    }
    /** Moves the second square to x, z (metres). */
    void place(float x, float z) {
        DplAvatarInfo info{};
        info.structSize = sizeof info;
        ASSERT_EQ(dplGetAvatarInfo(other_, &info), DPL_OK);
        std::vector<float> rotations(info.jointCount * 4);
        for (size_t j = 0; j < info.jointCount; ++j) rotations[4 * j + 3] = 1;
        const float root[3] = {x, 0, z};
        ASSERT_EQ(dplSetPose(other_, rotations.data(), info.jointCount, root), DPL_OK) << dplGetLastError();
    }
    DplAvatar other_ = nullptr, green_ = nullptr;
};

TEST_F(TogetherTest, theNearerOneIsInFrontWhicheverIsNamedFirst) {
    const DplCamera camera = frontCamera();
    place(0.25f, -0.5f);
    const size_t middle = 32 * 64 + 32, aside = 32 * 64 + 40;
    std::vector<uint8_t> alone, first, last;
    std::vector<float> depth;
    DplImage image = imageFor(camera, alone, &depth);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    EXPECT_EQ(alone[aside * 4 + 1], alone[middle * 4 + 1]);
    const DplAvatar sets[2][3] = {{avatar_, other_, green_}, {green_, other_, avatar_}};
    image = imageFor(camera, first, &depth);
    ASSERT_EQ(dplRenderTogether(context_, sets[0], 3, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_GT(first[middle * 4 + 1], 150) << "the green splat is nearer than the square";
    EXPECT_LT(first[middle * 4], 60);
    EXPECT_NEAR(depth[middle], 2.8f, 0.05f);
    EXPECT_GT(std::count_if(depth.begin(), depth.end(), [](float z) { return z > 3.3f && z < 3.6f; }), 20)
        << "pixels where only the square behind shows";
    image = imageFor(camera, last);
    ASSERT_EQ(dplRenderTogether(context_, sets[1], 3, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_EQ(first, last);
    EXPECT_FALSE(first == alone);
    // A scene set of one avatar draws the same picture as dplRender.
    std::vector<uint8_t> again;
    image = imageFor(camera, again);
    ASSERT_EQ(dplRenderTogether(context_, &avatar_, 1, &camera, 1, &image), DPL_OK);
    EXPECT_EQ(again, alone);
}

TEST_F(TogetherTest, meshDepthIsThatOfTheNearestMesh) {
    const DplCamera camera = frontCamera();
    place(0, 0.5f);
    std::vector<float> depth(64 * 64, -1);
    DplImage image{};
    image.structSize = sizeof image, image.meshDepthM = depth.data(), image.meshDepthCount = depth.size();
    const DplAvatar set[3] = {avatar_, green_, other_};
    ASSERT_EQ(dplRenderTogether(context_, set, 3, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_NEAR(depth[32 * 64 + 32], 2.5f, 1e-3f);
    EXPECT_EQ(depth[0], 0);
    EXPECT_EQ(dplRenderTogether(context_, &green_, 1, &camera, 1, &image), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("no mesh")) << dplGetLastError();
}

TEST_F(TogetherTest, anAvatarOutOfViewIsSkippedAndComesBack) {
    const DplCamera camera = frontCamera();
    const auto seen = [&](DplAvatar first) {
        DplFrameStats stats{};
        stats.structSize = sizeof stats;
        EXPECT_EQ(dplGetFrameStats(first, &stats), DPL_OK) << dplGetLastError();
        EXPECT_GT(stats.componentCount, 0u);
        return stats.componentsInView;
    };
    const DplAvatar sets[2][2] = {{avatar_, other_}, {other_, avatar_}};
    std::vector<uint8_t> both, alone, nobody;
    std::vector<float> depth(64 * 64), meshDepth(64 * 64);
    place(0.25f, -0.5f);
    DplImage image = imageFor(camera, both);
    ASSERT_EQ(dplRenderTogether(context_, sets[0], 2, &camera, 1, &image), DPL_OK) << dplGetLastError();
    const uint32_t ofBoth = seen(avatar_);
    image = imageFor(camera, alone);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    EXPECT_EQ(seen(avatar_) * 2, ofBoth);
    for (const auto& set : sets) {  // the avatar out of view comes last, then first
        place(9, 0);
        std::vector<uint8_t> pixels;
        image = imageFor(camera, pixels);
        ASSERT_EQ(dplRenderTogether(context_, set, 2, &camera, 1, &image), DPL_OK);
        EXPECT_EQ(seen(set[0]) * 2, ofBoth);
        EXPECT_EQ(pixels, alone);
        place(0.25f, -0.5f);
        image = imageFor(camera, pixels);
        ASSERT_EQ(dplRenderTogether(context_, set, 2, &camera, 1, &image), DPL_OK);
        EXPECT_EQ(pixels, both);
    }
    place(9, 0);
    image = imageFor(camera, nobody, &depth);
    std::fill(meshDepth.begin(), meshDepth.end(), -1.0f);
    image.meshDepthM = meshDepth.data(), image.meshDepthCount = meshDepth.size();
    ASSERT_EQ(dplRender(context_, other_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_EQ(seen(other_), 0u);
    EXPECT_EQ(nobody, std::vector<uint8_t>(64 * 64 * 4, 0));
    EXPECT_EQ(depth, std::vector<float>(64 * 64, 0)) << "no pixel of the frame before";
    EXPECT_EQ(meshDepth, std::vector<float>(64 * 64, 0));
}

TEST_F(TogetherTest, thePictureBelongsToTheFirstAvatar) {
    const DplCamera camera = frontCamera();
    const DplAvatar set[2] = {avatar_, other_};
    place(0.5f, 0);
    ASSERT_EQ(dplDrawTogether(context_, set, 2, &camera, 1, DPL_DRAW_DEPTH), DPL_OK) << dplGetLastError();
    std::vector<uint8_t> drawn, rendered;
    DplImage image = imageFor(camera, drawn);
    EXPECT_EQ(dplReadImages(context_, other_, &image, 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("nothing was drawn")) << dplGetLastError();
    ASSERT_EQ(dplReadImages(context_, avatar_, &image, 1), DPL_OK) << dplGetLastError();
    image = imageFor(camera, rendered);
    ASSERT_EQ(dplRenderTogether(context_, set, 2, &camera, 1, &image), DPL_OK);
    EXPECT_EQ(drawn, rendered);
    DplFrameStats one{}, two{};
    one.structSize = two.structSize = sizeof one;
    ASSERT_EQ(dplGetFrameStats(avatar_, &two), DPL_OK);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    ASSERT_EQ(dplGetFrameStats(avatar_, &one), DPL_OK);
    EXPECT_EQ(two.splatsDrawn, 2 * one.splatsDrawn);
}

TEST_F(TogetherTest, invalidSceneSetsAreRefused) {
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera, pixels);
    const auto refused = [&](const DplAvatar* set, uint32_t count, const char* why) {
        const bool refusedBoth = dplRenderTogether(context_, set, count, &camera, 1, &image) == DPL_ERROR_INVALID_ARGUMENT &&
                                 dplDrawTogether(context_, set, count, &camera, 1, 0) == DPL_ERROR_INVALID_ARGUMENT;
        EXPECT_TRUE(errorSays(why)) << dplGetLastError();
        return refusedBoth && std::all_of(pixels.begin(), pixels.end(), [](uint8_t b) { return b == 0xAA; });
    };
    const std::vector<DplAvatar> many(17, avatar_);
    const DplAvatar twice[2] = {avatar_, avatar_}, none[2] = {avatar_, nullptr};
    EXPECT_TRUE(refused(nullptr, 1, "NULL"));
    EXPECT_TRUE(refused(twice, 0, "1 to 16"));
    EXPECT_TRUE(refused(many.data(), 17, "1 to 16"));
    EXPECT_TRUE(refused(twice, 2, "twice"));
    EXPECT_TRUE(refused(none, 2, "avatar"));
    DplContext elsewhere = nullptr;
    const DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_SOFTWARE, 1};
    ASSERT_EQ(dplCreateContext(&info, &elsewhere), DPL_OK);
    const auto bytes = tinyFile();
    DplAvatar stranger = nullptr;
    ASSERT_EQ(dplLoadAvatar(elsewhere, bytes.data(), bytes.size(), &stranger), DPL_OK);
    const DplAvatar mixed[2] = {avatar_, stranger};
    EXPECT_TRUE(refused(mixed, 2, "another context"));
    EXPECT_EQ(dplDestroyAvatar(stranger), DPL_OK);
    EXPECT_EQ(dplDestroyContext(elsewhere), DPL_OK);
}

}  // namespace
}  // namespace dpl::test
