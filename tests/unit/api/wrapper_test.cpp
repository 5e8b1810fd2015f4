// SPDX-License-Identifier: Apache-2.0
// What doppel.hpp and doppel_picture.hpp do beyond forwarding, and what stderr is told.
#include "sdk/include/doppel/doppel.hpp"
#include "sdk/include/doppel/doppel_picture.hpp"
#include "tests/unit/api/api_fixture.h"

namespace dpl {
namespace {

class WrapperTest : public test::ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        tiny_ = doppel::Avatar(context_, std::exchange(avatar_, nullptr));
    }
    void TearDown() override {
        tiny_ = {};
        ApiTest::TearDown();
    }
    doppel::Avatar tiny_;
};

TEST_F(WrapperTest, anAvatarAndAContextMayBeMadeEmptyAndFilledLater) {
    doppel::Context context;
    EXPECT_EQ(context.handle(), nullptr);
    EXPECT_EQ(context.loadAvatarFile("avatar.glb").error().code, DPL_ERROR_INVALID_ARGUMENT);
    context = std::move(*doppel::Context::create(DPL_RENDERER_SOFTWARE, 1));
    EXPECT_NE(context.handle(), nullptr);
    doppel::Avatar avatar;
    EXPECT_EQ(avatar.info().error().code, DPL_ERROR_INVALID_ARGUMENT);
    avatar = std::move(tiny_);
    EXPECT_TRUE(avatar.info());
    tiny_ = std::move(avatar);
}

TEST_F(WrapperTest, aClipGoesByItsName) {
    EXPECT_EQ(*tiny_.findClip("turn"), 0u);
    const auto missing = tiny_.findClip("dance");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, DPL_ERROR_NOT_FOUND);
    EXPECT_NE(missing.error().message.find("'dance'; the avatar has: turn"), std::string::npos) << missing.error().message;
    ASSERT_TRUE(tiny_.setPoseFromClip("turn", 0.5));
    std::array<float, 3> root{};
    ASSERT_TRUE(tiny_.pose({}, root));
    EXPECT_NEAR(root[1], 0.25f, 1e-5f);
    EXPECT_EQ(tiny_.setPoseFromClip("dance", 0).error().code, DPL_ERROR_NOT_FOUND);
}

TEST_F(WrapperTest, standPlacesUprightAndTurned) {
    ASSERT_TRUE(tiny_.stand({1, 2, 3}, float(M_PI) / 2, 2));
    const auto rows = *tiny_.transform();
    const std::array<float, 12> expected = {0, 0, 2, 1, 0, 2, 0, 2, -2, 0, 0, 3};
    for (size_t i = 0; i < 12; ++i) EXPECT_NEAR(rows[i], expected[i], 1e-6f) << i;
    EXPECT_FALSE(tiny_.stand({0, 0, 0}, NAN));
    EXPECT_FALSE(tiny_.stand({0, 0, 0}, 0, -1));
    EXPECT_EQ(*tiny_.transform(), rows);
}

TEST_F(WrapperTest, severalAvatarsAreNamedInOneCall) {
    const auto bytes = test::tinyFile();
    DplAvatar second = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &second), DPL_OK);
    const doppel::Avatar other(context_, second);
    doppel::Context context(context_);
    doppel::Picture alone(64, 64), together(64, 64), byHandles(64, 64);
    const auto camera = alone.camera({.eye = {0, 1, 4}, .target = {0, 1, 0}});
    ASSERT_TRUE(camera);
    ASSERT_TRUE(tiny_.stand({-0.6f, 0, 0}));
    ASSERT_TRUE(tiny_.render(*camera, alone.image()));
    ASSERT_TRUE(context.renderTogether({tiny_, other}, *camera, together.image()));
    const DplAvatar handles[] = {tiny_.handle(), second};
    ASSERT_TRUE(context.renderTogether(handles, *camera, byHandles.image()));
    EXPECT_TRUE(std::equal(together.rgba().begin(), together.rgba().end(), byHandles.rgba().begin()));
    EXPECT_FALSE(std::equal(together.rgba().begin(), together.rgba().end(), alone.rgba().begin()));
    EXPECT_FALSE(context.renderTogether({tiny_, tiny_}, *camera, together.image()));
    EXPECT_FALSE(context.renderTogether(
        {other, other, other, other, other, other, other, other, other, other, other, other, other, other, other, other, other}, *camera,
        together.image()));
    EXPECT_TRUE(errorSays("17 avatars")) << dplGetLastError();
    context_ = nullptr;  // `context` owns it
}

TEST_F(WrapperTest, aPictureDarkensTheFloorBelowAShadow) {
    doppel::ContactShadow shadow;
    shadow.darkest = 255, shadow.corner[0] = shadow.corner[2] = -0.5f, shadow.across[0] = shadow.along[2] = 1;
    for (size_t y = 16; y < 48; ++y) std::fill_n(&shadow.alpha[y * 64 + 40], 16, uint8_t(255));  // right of the middle
    doppel::Picture picture(65, 65);
    picture.fill(200, 100, 50);
    const auto camera = picture.camera({.eye = {0, 2, 0.0f}, .target = {0, 0, 0}, .up = {0, 0, -1}});  // from above: +X to the right
    ASSERT_TRUE(camera);
    picture.drawShadow(shadow, *camera, 0.5f);
    const auto red = [&](size_t x, size_t y) { return int(picture.rgba()[4 * (y * 65 + x)]); };
    const size_t metre = size_t(camera->fx / 2);
    EXPECT_EQ(red(32 - metre / 4, 32), 200);
    EXPECT_EQ(red(32 + metre / 4, 32), 100);
    EXPECT_EQ(red(32 + metre / 4, 32 - metre / 3), 200);
    EXPECT_EQ(picture.rgba()[3], 255);
    doppel::Picture clear(65, 65);
    clear.drawShadow(shadow, *camera, 0.5f);
    EXPECT_NEAR(int(clear.rgba()[4 * (32 * 65 + 32 + metre / 4) + 3]), 128, 1);
    doppel::Picture below(65, 65);
    below.fill(200, 100, 50);
    below.drawShadow(shadow, *below.camera({.eye = {0, 1, 3}, .target = {0, 2, 0}}));  // the floor is not in view
    EXPECT_EQ(int(below.rgba()[0]), 200);
    EXPECT_EQ(picture.write("/nowhere/at/all.png").error().code, DPL_ERROR_IO);
    EXPECT_EQ(doppel::readFile("/nowhere/at/all.bvh").error().code, DPL_ERROR_NOT_FOUND);
}

TEST_F(WrapperTest, stderrIsNotToldWhatACallReturns) {
    ASSERT_EQ(dplGetAvatarInfo(nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(log_.find("dplGetAvatarInfo"), std::string::npos);  // a callback is
    ASSERT_EQ(dplSetLogCallback(nullptr, nullptr), DPL_OK);
    testing::internal::CaptureStderr();
    EXPECT_EQ(dplGetAvatarInfo(nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("0 is not a live avatar"));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    const std::string strange = "ply\nformat ascii 1.0\nelement vertex 1\n";
    testing::internal::CaptureStderr();
    DplAvatar none = nullptr;
    EXPECT_NE(dplLoadAvatar(context_, reinterpret_cast<const uint8_t*>(strange.data()), strange.size(), &none), DPL_OK);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace dpl
