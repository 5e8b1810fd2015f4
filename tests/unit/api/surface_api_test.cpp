// SPDX-License-Identifier: Apache-2.0
// The calls about the posed surface of an avatar.
#include "sdk/include/doppel/doppel.hpp"
#include "tests/not_finite.h"
#include "tests/unit/api/api_fixture.h"

namespace dpl {
namespace {

/** A box of two soles' size whose lower side is at y = 0, with splats on every triangle. */
AvatarData block() {
    AvatarData a = test::tinyAvatar();
    a.mesh.restPositions.clear(), a.mesh.triangles.clear();
    for (int corner = 0; corner < 8; ++corner)
        a.mesh.restPositions.push_back({corner & 1 ? 0.15f : -0.15f, corner & 2 ? 0.5f : 0.0f, corner & 4 ? 0.1f : -0.1f});
    a.mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {4, 6, 5}, {5, 6, 7}, {0, 4, 1}, {1, 4, 5},
                        {2, 3, 6}, {3, 7, 6}, {0, 2, 4}, {2, 6, 4}, {1, 5, 3}, {3, 5, 7}};
    a.mesh.colours.assign(8, glm::u8vec4(255));
    a.mesh.jointIndices.assign(8, glm::u16vec4(0));
    a.mesh.jointWeights.assign(8, glm::u8vec4(255, 0, 0, 0));
    a.mesh.layers = {{"body", "body", 0, 8, 0, 12}};
    a.splats.triangleStart.assign(13, 128);
    a.splats.triangleStart[0] = 0, a.splats.triangleStart[1] = 64;
    return a;
}

constexpr float kFileM = 5e-5f;  // twice what a file rounds positions of a mesh of this size by

class SurfaceApiTest : public test::ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        AvatarData data = block();
        sortSplats(data);
        const auto bytes = writeAvatar(data);
        ASSERT_TRUE(bytes) << bytes.error().message;
        DplAvatar handle = nullptr;
        ASSERT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &handle), DPL_OK) << dplGetLastError();
        block_.emplace(context_, handle);
    }
    void TearDown() override {
        block_.reset();
        ApiTest::TearDown();
    }
    void place(float scale, const std::array<float, 3>& at) {
        ASSERT_TRUE(block_->setTransform(std::array<float, 12>{0, 0, scale, at[0], 0, scale, 0, at[1], -scale, 0, 0, at[2]}));
    }
    doppel::ContactShadow shadow(std::optional<float> floorM = {}) const {
        auto made = block_->contactShadow(floorM);
        EXPECT_TRUE(made) << (made ? "" : made.error().message);
        return made ? *made : doppel::ContactShadow();
    }

    std::optional<doppel::Avatar> block_;
};

TEST_F(SurfaceApiTest, shadow_isTheSamePictureAtEveryScaleAndPlace) {
    const auto home = shadow();
    ASSERT_GT(home.darkest, 200u);
    EXPECT_NEAR(home.corner[1], 0, 1e-6);
    for (const float scale : {0.1f, 1.0f, 10.0f}) {
        place(scale, {3, 2, -5});
        const auto there = shadow();
        EXPECT_EQ(there.alpha, home.alpha) << scale;
        EXPECT_NEAR(there.corner[0], 3 + scale * home.corner[2], 1e-4) << scale;
        EXPECT_NEAR(there.corner[1], 2, 1e-5) << scale;
        EXPECT_NEAR(there.corner[2], -5 - scale * home.corner[0], 1e-4) << scale;
        EXPECT_NEAR(there.across[2], -scale * home.across[0], 1e-4) << scale;
        EXPECT_NEAR(there.along[0], scale * home.along[2], 1e-4) << scale;
    }
}

TEST_F(SurfaceApiTest, shadow_liesOnTheFloorOfTheApp) {
    place(2, {0, 1, 0});
    const auto lower = shadow(0.8f);  // 0.1 of its own metres below the soles
    EXPECT_NEAR(lower.corner[1], 0.8, 1e-5);
    EXPECT_GT(lower.darkest, 60u);
    EXPECT_LT(lower.darkest, shadow(1.0f).darkest);
    EXPECT_EQ(shadow(1.0f).alpha, shadow().alpha);
    const auto far = shadow(0.0f);
    EXPECT_EQ(far.darkest, 0u);
    EXPECT_EQ(far.alpha, doppel::ContactShadow().alpha);
    ASSERT_TRUE(block_->setTransform(std::array<float, 12>{0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}));  // it lies on its side
    const auto lying = shadow(-0.15f);
    EXPECT_GT(lying.darkest, 200u);
    EXPECT_NEAR(lying.corner[1], -0.15, 1e-5);
    EXPECT_NEAR(lying.along[1], 0, 1e-6);
    EXPECT_GT(std::abs(shadow().across[1]) + std::abs(shadow().along[1]), 0.9f);  // its own floor leans with it
}

TEST_F(SurfaceApiTest, shadow_followsThePose) {
    const std::vector<float> rest = {0, 0, 0, 1, 0, 0, 0, 1};
    const auto before = shadow();
    ASSERT_TRUE(block_->setPose(rest, std::array<float, 3>{0, 0.4f, 0}));
    EXPECT_EQ(shadow().darkest, 0u);
    ASSERT_TRUE(block_->setPose(rest, std::array<float, 3>{0, 0.1f, 0}));
    EXPECT_GT(shadow().darkest, 0u);
    EXPECT_LT(shadow().darkest, before.darkest);
    ASSERT_TRUE(block_->setPose(rest));
    EXPECT_EQ(shadow().alpha, before.alpha);
}

TEST_F(SurfaceApiTest, shadow_refusesWhatIsWrongAndWritesNothing) {
    std::vector<uint8_t> alpha(DPL_CONTACT_SHADOW_PX * DPL_CONTACT_SHADOW_PX, 7);
    DplContactShadow place{};
    place.structSize = sizeof place, place.darkest = 99;
    for (const float floor : {kNan, kInfinity, -kInfinity, 2e5f}) {
        EXPECT_EQ(dplGetContactShadow(block_->handle(), &floor, alpha.data(), alpha.size(), &place), DPL_ERROR_INVALID_ARGUMENT);
        EXPECT_TRUE(errorSays("the floor is at")) << dplGetLastError();
    }
    EXPECT_EQ(dplGetContactShadow(block_->handle(), nullptr, nullptr, alpha.size(), &place), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetContactShadow(block_->handle(), nullptr, alpha.data(), alpha.size() - 1, &place), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("4096")) << dplGetLastError();
    EXPECT_EQ(dplGetContactShadow(nullptr, nullptr, alpha.data(), alpha.size(), &place), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetContactShadow(block_->handle(), nullptr, alpha.data(), alpha.size(), nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(place.darkest, 99u);
    EXPECT_EQ(alpha, std::vector<uint8_t>(alpha.size(), 7));
}

TEST_F(SurfaceApiTest, posedMesh_followsThePoseAndStaysInItsOwnSpace) {
    const auto rest = block_->posedVertices();
    ASSERT_TRUE(rest) << rest.error().message;
    ASSERT_EQ(rest->size(), 24u);
    const auto box = std::minmax_element(rest->begin(), rest->end());
    EXPECT_NEAR(*box.first, -0.15f, kFileM);
    EXPECT_NEAR(*box.second, 0.5f, kFileM);
    place(2, {3, 0, 0});
    EXPECT_EQ(*block_->posedVertices(), *rest);
    ASSERT_TRUE(block_->setPose(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1}, std::array<float, 3>{0, 0.25f, 0}));
    const auto moved = block_->posedVertices();
    for (size_t i = 0; i < rest->size(); ++i) EXPECT_NEAR((*moved)[i], (*rest)[i] + (i % 3 == 1 ? 0.25f : 0), 1e-6f) << i;
    const auto triangles = block_->meshTriangles();
    ASSERT_TRUE(triangles) << triangles.error().message;
    ASSERT_EQ(triangles->size(), 36u);
    double volume = 0;  // of the closed box, whatever the order of its vertices in the file
    const auto corner = [&](size_t i, size_t axis) { return double((*rest)[(*triangles)[i] * 3 + axis]); };
    for (size_t t = 0; t < 36; t += 3)
        volume += (corner(t, 0) * (corner(t + 1, 1) * corner(t + 2, 2) - corner(t + 1, 2) * corner(t + 2, 1)) +
                   corner(t, 1) * (corner(t + 1, 2) * corner(t + 2, 0) - corner(t + 1, 0) * corner(t + 2, 2)) +
                   corner(t, 2) * (corner(t + 1, 0) * corner(t + 2, 1) - corner(t + 1, 1) * corner(t + 2, 0))) /
                  6;
    EXPECT_NEAR(std::abs(volume), 0.3 * 0.5 * 0.2, 1e-4);
}

TEST_F(SurfaceApiTest, posedMesh_refusesOtherCounts) {
    float positions[24] = {};
    uint32_t triangles[36] = {};
    const DplAvatar avatar = block_->handle();
    for (const uint32_t count : {0u, 7u, 9u}) {
        EXPECT_EQ(dplGetPosedMesh(avatar, positions, count, triangles, 12), DPL_ERROR_INVALID_ARGUMENT);
        EXPECT_TRUE(errorSays("the avatar has 8")) << dplGetLastError();
    }
    EXPECT_EQ(dplGetPosedMesh(avatar, positions, 8, triangles, 11), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetPosedMesh(avatar, nullptr, 8, triangles, 12), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetPosedMesh(avatar, nullptr, 0, nullptr, 12), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetPosedMesh(nullptr, positions, 8, triangles, 12), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetPosedMesh(avatar, nullptr, 0, nullptr, 0), DPL_OK);
    for (const float x : positions) EXPECT_EQ(x, 0);
}

TEST_F(SurfaceApiTest, pick_tellsAvatarLayerJointPointAndSide) {
    place(2, {3, 0, 0});  // the front of the block, z = 0.1 of its own, faces +X
    const std::array<float, 3> origin{13, 0.5f, 0.1f};
    const auto pick = doppel::pick({*block_}, origin, {-3, 0, 0});
    ASSERT_TRUE(pick) << pick.error().message;
    ASSERT_TRUE(pick->hit);
    EXPECT_EQ(pick->avatar, 0u);
    EXPECT_EQ(pick->layer, 0u);  // an avatar without clothes as layers is its body
    EXPECT_STREQ(block_->layer(pick->layer)->role, "body");
    EXPECT_EQ(pick->joint, 0u);
    EXPECT_NEAR(pick->distanceM, 9.8f, kFileM);
    EXPECT_NEAR(pick->point[0], 3.2f, kFileM);
    EXPECT_NEAR(pick->point[1], 0.5f, kFileM);
    EXPECT_NEAR(pick->normal[0], 1, 1e-6f);
    const auto within = doppel::pick({*block_}, {3, 0.5f, 0}, {1, 0, 0});
    ASSERT_TRUE(within && within->hit);
    EXPECT_NEAR(within->distanceM, 0.2f, kFileM);
    EXPECT_NEAR(within->normal[0], -1, 1e-6f);  // towards where the ray comes from
    const auto away = doppel::pick({*block_}, origin, {3, 0, 0});
    ASSERT_TRUE(away);
    EXPECT_FALSE(away->hit);
    EXPECT_EQ(away->distanceM, 0);
}

TEST_F(SurfaceApiTest, pick_takesTheNearestAvatarAndFollowsItsPose) {
    doppel::Avatar tiny(context_, std::exchange(avatar_, nullptr));
    ASSERT_TRUE(tiny.setTransform(std::array<float, 12>{1, 0, 0, 0, 0, 1, 0, -0.75f, 0, 0, 1, -1}));
    const std::array<float, 3> origin{0, 0.25f, 5}, direction{0, 0, -1};
    EXPECT_EQ(doppel::pick({tiny, *block_}, origin, direction)->avatar, 1u);
    EXPECT_EQ(doppel::pick({*block_, tiny}, origin, direction)->avatar, 0u);
    EXPECT_NEAR(doppel::pick({tiny}, origin, direction)->distanceM, 6, kFileM);
    ASSERT_TRUE(block_->setPose(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1}, std::array<float, 3>{5, 0, 0}));
    EXPECT_EQ(doppel::pick({tiny, *block_}, origin, direction)->avatar, 0u);
}

TEST_F(SurfaceApiTest, pick_refusesWhatIsWrong) {
    const float nowhere[3] = {0, kNan, 0}, far[3] = {0, 0, 2e5f}, origin[3] = {0, 0, 3}, direction[3] = {0, 0, -1}, zero[3] = {0, 0, 0};
    const DplAvatar avatar = block_->handle();
    DplPick pick{};
    pick.structSize = sizeof pick, pick.hit = 9;
    const auto refused = [&](const DplAvatar* avatars, uint32_t count, const float* from, const float* along, const char* text) {
        EXPECT_EQ(dplPick(avatars, count, from, along, &pick), DPL_ERROR_INVALID_ARGUMENT) << text;
        EXPECT_TRUE(errorSays(text)) << dplGetLastError();
    };
    refused(&avatar, 1, nowhere, direction, "origin is not finite");
    refused(&avatar, 1, far, direction, "beyond");
    refused(&avatar, 1, origin, nowhere, "direction is not finite");
    refused(&avatar, 1, origin, zero, "direction is 0");
    refused(&avatar, 1, nullptr, direction, "origin is NULL");
    refused(&avatar, 1, origin, nullptr, "direction is NULL");
    refused(&avatar, 0, origin, direction, "0 avatars");
    refused(nullptr, 1, origin, direction, "avatars is NULL");
    DplAvatar room = nullptr;
    const std::string ply =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
        "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\nproperty float opacity\nproperty float scale_0\n"
        "property float scale_1\nproperty float scale_2\nproperty float rot_0\nproperty float rot_1\nproperty float rot_2\n"
        "property float rot_3\nend_header\n" +
        std::string(40, 0) + std::string("\0\0\x80\x3f", 4) + std::string(12, 0);
    ASSERT_EQ(dplLoadAvatar(context_, reinterpret_cast<const uint8_t*>(ply.data()), ply.size(), &room), DPL_OK) << dplGetLastError();
    const DplAvatar both[] = {avatar, room};
    refused(both, 2, origin, direction, "avatar 1: these are general splats");
    EXPECT_EQ(dplHideLayer(room, 0, DPL_TRUE), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetPosedMesh(room, nullptr, 0, nullptr, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(pick.hit, 9u);
    EXPECT_EQ(dplDestroyAvatar(room), DPL_OK);
}

}  // namespace
}  // namespace dpl
