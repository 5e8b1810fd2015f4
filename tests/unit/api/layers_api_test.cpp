// SPDX-License-Identifier: Apache-2.0
// Layers that are hidden, by the CPU and by Vulkan.
#include <algorithm>
#include <cmath>

#include "tests/unit/api/api_fixture.h"
#include "tests/unit/surface/dressed.h"

namespace dpl {
namespace {

using test::kBody, test::kCoat, test::kScarf, test::kSkirt, test::kTop;

struct Way {
    const char* name;
    DplRenderer renderer;
    DplFill fill;
};

class LayersApiTest : public ::testing::TestWithParam<Way> {
protected:
    void SetUp() override {
        const DplContextInfo info{sizeof(DplContextInfo), GetParam().renderer, 2, 0, GetParam().fill, nullptr};
        const DplResult made = dplCreateContext(&info, &context_);
        if (made != DPL_OK && info.renderer == DPL_RENDERER_VULKAN) GTEST_SKIP() << "no Vulkan here: " << dplGetLastError();
        ASSERT_EQ(made, DPL_OK) << dplGetLastError();
        AvatarData data = test::dressed();
        sortSplats(data);
        const auto bytes = writeAvatar(data);
        ASSERT_TRUE(bytes) << bytes.error().message;
        ASSERT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &avatar_), DPL_OK) << dplGetLastError();
    }
    void TearDown() override {
        dplDestroyAvatar(avatar_);
        dplDestroyContext(context_);
    }
    DplResult hide(uint32_t layer, int hidden = DPL_TRUE) { return dplHideLayer(avatar_, layer, hidden); }
    bool errorSays(const char* text) const { return std::string(dplGetLastError()).find(text) != std::string::npos; }

    /** Premultiplied RGBA8, then the depth of the mesh where it is asked for. */
    std::vector<uint8_t> picture(std::vector<float>* meshDepth = nullptr) {
        const DplCamera camera = test::frontCamera(96, 96);
        std::vector<uint8_t> pixels(96 * 96 * 4);
        DplImage image{sizeof(DplImage), 0, pixels.data(), pixels.size()};
        if (meshDepth) meshDepth->resize(96 * 96), image.meshDepthM = meshDepth->data(), image.meshDepthCount = meshDepth->size();
        EXPECT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
        return pixels;
    }
    /** Colour of the place at x, y of the sheets: 1 in a channel is full. */
    static Vec3f at(const std::vector<uint8_t>& pixels, float x, float y) { return Vec3f(channels(pixels, x, y)) / 255.0f; }
    static size_t pixelAt(float x, float y) { return size_t(48 + (1 - y) * 30) * 96 + size_t(48 + x * 30); }
    static Vec4f channels(const std::vector<uint8_t>& pixels, float x, float y) {
        const uint8_t* p = &pixels[4 * pixelAt(x, y)];
        return {p[0], p[1], p[2], p[3]};
    }

    DplContext context_ = nullptr;
    DplAvatar avatar_ = nullptr;
};

TEST_P(LayersApiTest, aHiddenLayerShowsWhatLiesBelowAndComesBackByteForByte) {
    std::vector<float> depth;
    const auto whole = picture(&depth);
    EXPECT_GT(at(whole, -0.3f, 1).g, 0.8f);
    EXPECT_GT(at(whole, -0.3f, 1).r, 0.8f);
    EXPECT_NEAR(depth[pixelAt(-0.3f, 1)], 2.94f, 1e-3f);
    ASSERT_EQ(hide(kCoat), DPL_OK) << dplGetLastError();
    const auto withoutCoat = picture(&depth);
    EXPECT_GT(at(withoutCoat, -0.3f, 1).g, 0.8f);
    EXPECT_LT(at(withoutCoat, -0.3f, 1).r, 0.2f);
    EXPECT_GT(at(withoutCoat, 0.3f, 1).b, 0.8f);
    EXPECT_NEAR(depth[pixelAt(-0.3f, 1)], 2.98f, 1e-3f);
    ASSERT_EQ(hide(kTop), DPL_OK) << dplGetLastError();
    const auto without = picture(&depth);
    EXPECT_GT(at(without, -0.3f, 1).r, 0.8f);
    EXPECT_LT(at(without, -0.3f, 1).g, 0.2f);
    EXPECT_NEAR(depth[pixelAt(-0.3f, 1)], 3, 1e-3f);
    EXPECT_EQ(picture(), without);  // without the depth of the mesh, too
    ASSERT_EQ(hide(kTop, DPL_FALSE), DPL_OK);
    EXPECT_EQ(picture(), withoutCoat);
    ASSERT_EQ(hide(kCoat, DPL_FALSE), DPL_OK);
    EXPECT_EQ(picture(), whole);
    EXPECT_EQ(hide(kScarf, DPL_FALSE), DPL_OK);  // it was never hidden
    EXPECT_EQ(picture(), whole);
}

TEST_P(LayersApiTest, whatHasNoSplatsBelowStaysAndSaysWhy) {
    const auto whole = picture();
    EXPECT_EQ(hide(kSkirt), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(errorSays("'skirt' cannot be hidden") && errorSays("no splats")) << dplGetLastError();
    EXPECT_EQ(hide(kScarf), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(errorSays("nothing lies below 'scarf'")) << dplGetLastError();
    EXPECT_EQ(hide(kBody), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(errorSays("is the body")) << dplGetLastError();
    EXPECT_EQ(hide(5), DPL_ERROR_NOT_FOUND);
    EXPECT_EQ(hide(0xffffffff, DPL_FALSE), DPL_ERROR_NOT_FOUND);
    EXPECT_EQ(picture(), whole);
}

TEST_P(LayersApiTest, picksAndTellsOfLayers) {
    const float origin[3] = {-0.3f, 1, 5}, direction[3] = {0, 0, -2};
    DplPick pick{};
    pick.structSize = sizeof pick;
    ASSERT_EQ(dplPick(&avatar_, 1, origin, direction, &pick), DPL_OK) << dplGetLastError();
    EXPECT_EQ(pick.layer, uint32_t(kCoat));
    ASSERT_EQ(hide(kCoat), DPL_OK);
    ASSERT_EQ(dplPick(&avatar_, 1, origin, direction, &pick), DPL_OK);
    EXPECT_EQ(pick.layer, uint32_t(kTop));
    EXPECT_NEAR(pick.distanceM, 4.98f, 1e-5f);
    DplLayerInfo info{};
    info.structSize = sizeof info;
    ASSERT_EQ(dplGetLayerInfo(avatar_, pick.layer, &info), DPL_OK);
    EXPECT_STREQ(info.name, "top");
    EXPECT_STREQ(info.role, "garment");
    EXPECT_EQ(info.triangleCount, 32u);
    EXPECT_EQ(info.hidden, uint32_t(DPL_FALSE));
    ASSERT_EQ(dplGetLayerInfo(avatar_, kCoat, &info), DPL_OK);
    EXPECT_EQ(info.hidden, uint32_t(DPL_TRUE));
    DplAvatarInfo about{};
    about.structSize = sizeof about;
    ASSERT_EQ(dplGetAvatarInfo(avatar_, &about), DPL_OK);
    std::vector<uint32_t> triangles(3 * about.triangleCount);
    ASSERT_EQ(dplGetPosedMesh(avatar_, nullptr, 0, triangles.data(), about.triangleCount), DPL_OK) << dplGetLastError();
    uint32_t leftOut = 0;
    for (uint32_t t = 0; t < about.triangleCount; ++t) leftOut += triangles[3 * t] == triangles[3 * t + 1];
    EXPECT_EQ(leftOut, info.triangleCount);
    EXPECT_EQ(dplGetLayerInfo(avatar_, 5, &info), DPL_ERROR_NOT_FOUND);
}

TEST_P(LayersApiTest, aHiddenLayerCastsNoShadow) {
    const float lying[8] = {-std::sqrt(0.5f), 0, 0, std::sqrt(0.5f), 0, 0, 0, 1};  // faces up: the coat lies highest
    ASSERT_EQ(dplSetPose(avatar_, lying, 2, nullptr), DPL_OK) << dplGetLastError();
    float joints[6];
    ASSERT_EQ(dplGetJointPositions(avatar_, joints, 2), DPL_OK);
    const float floorM = joints[1] + 0.06f + 0.2f;  // 0.2 m from the coat, 0.24 m and more from what lies below it
    const auto shadow = [&] {
        std::vector<uint8_t> alpha(DPL_CONTACT_SHADOW_PX * DPL_CONTACT_SHADOW_PX);
        DplContactShadow place{};
        place.structSize = sizeof place;
        EXPECT_EQ(dplGetContactShadow(avatar_, &floorM, alpha.data(), alpha.size(), &place), DPL_OK) << dplGetLastError();
        return alpha;
    };
    const auto whole = shadow();
    ASSERT_EQ(hide(kCoat), DPL_OK) << dplGetLastError();
    const auto without = shadow();
    EXPECT_GT(*std::ranges::max_element(without), 0);
    EXPECT_GT(*std::ranges::max_element(whole), 2 * *std::ranges::max_element(without));
    ASSERT_EQ(hide(kCoat, DPL_FALSE), DPL_OK);
    EXPECT_EQ(shadow(), whole);
}

INSTANTIATE_TEST_SUITE_P(Renderers, LayersApiTest,
                         ::testing::Values(Way{"software", DPL_RENDERER_SOFTWARE, DPL_FILL_AUTO},
                                           Way{"quads", DPL_RENDERER_VULKAN, DPL_FILL_QUADS},
                                           Way{"tiles", DPL_RENDERER_VULKAN, DPL_FILL_TILES}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace dpl
