// SPDX-License-Identifier: Apache-2.0
// Where avatars and general splats stand, through the public API.
#include <array>
#include <cmath>
#include <limits>

#include "sdk/format/ply.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {
namespace {

using Rows = std::array<float, 12>;
constexpr Rows kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
constexpr Rows kTurned = {0, 0, 2, 0.5f, 0, 2, 0, -1, -2, 0, 0, 3};  // a quarter turn about +Y, twice as large

class TransformTest : public ApiTest {
protected:
    Rows transform(DplAvatar avatar) {
        Rows rows{};
        EXPECT_EQ(dplGetTransform(avatar, rows.data()), DPL_OK) << dplGetLastError();
        return rows;
    }
    std::vector<uint8_t> picture(DplAvatar avatar, const DplCamera& camera, std::vector<float>* depth = nullptr) {
        std::vector<uint8_t> pixels;
        const DplImage image = imageFor(camera, pixels, depth);
        EXPECT_EQ(dplRender(context_, avatar, &camera, 1, &image), DPL_OK) << dplGetLastError();
        return pixels;
    }
    /** Expects a sentence that contains `why`, and that the transform stays. */
    void refused(const Rows& rows, const char* why) {
        ASSERT_EQ(dplSetTransform(avatar_, kTurned.data()), DPL_OK);
        EXPECT_EQ(dplSetTransform(avatar_, rows.data()), DPL_ERROR_INVALID_ARGUMENT) << why;
        EXPECT_TRUE(errorSays(why)) << dplGetLastError();
        EXPECT_TRUE(errorSays("worldFromAvatar")) << dplGetLastError();
        EXPECT_EQ(transform(avatar_), kTurned);
    }
};

/** The camera of avatar space, and of its metres, that sees what `camera` sees of an avatar that is placed. */
DplCamera cameraMovedTheOtherWay(const DplCamera& camera, const Rows& placed, double scale) {
    DplCamera own = camera;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) {
            double sum = column == 3 ? double(camera.viewFromWorld[4 * row + 3]) : 0;
            for (int k = 0; k < 3; ++k) sum += double(camera.viewFromWorld[4 * row + k]) * double(placed[size_t(4 * k + column)]);
            own.viewFromWorld[4 * row + column] = float(sum / scale);
        }
    return own;
}

TEST_F(TransformTest, isTheIdentityUntilSetAndNullBringsItBack) {
    EXPECT_EQ(transform(avatar_), kIdentity);
    const DplCamera camera = frontCamera();
    const std::vector<uint8_t> before = picture(avatar_, camera);
    ASSERT_EQ(dplSetTransform(avatar_, kTurned.data()), DPL_OK) << dplGetLastError();
    EXPECT_EQ(transform(avatar_), kTurned);
    EXPECT_FALSE(picture(avatar_, camera) == before);
    ASSERT_EQ(dplSetTransform(avatar_, kIdentity.data()), DPL_OK);
    EXPECT_EQ(picture(avatar_, camera), before) << "the same bytes";
    ASSERT_EQ(dplSetTransform(avatar_, kTurned.data()), DPL_OK);
    ASSERT_EQ(dplSetTransform(avatar_, nullptr), DPL_OK);
    EXPECT_EQ(transform(avatar_), kIdentity);
    EXPECT_EQ(picture(avatar_, camera), before);
}

TEST_F(TransformTest, thePictureIsThatOfACameraMovedTheOtherWayInMetresOfTheWorld) {
    DplCamera camera = frontCamera();
    // The square of 1 m around (0, 1, 0) is turned to face +X, and stands as one of 2 m around (0.5, 1, 3): look from +X.
    const float fromTheSide[12] = {0, 0, -1, 3, 0, -1, 0, 1, -1, 0, 0, 5};
    std::copy_n(fromTheSide, 12, camera.viewFromWorld);
    std::vector<float> depth, ownDepth;
    const std::vector<uint8_t> own = picture(avatar_, cameraMovedTheOtherWay(camera, kTurned, 2), &ownDepth);
    ASSERT_EQ(dplSetTransform(avatar_, kTurned.data()), DPL_OK);
    const std::vector<uint8_t> placed = picture(avatar_, camera, &depth);
    EXPECT_EQ(placed, own);
    const size_t middle = 32 * 64 + 32;
    EXPECT_GT(placed[4 * middle + 3], 200);
    EXPECT_NEAR(depth[middle], 4.5f, 1e-3f);
    EXPECT_NEAR(ownDepth[middle], 2.25f, 1e-3f);
    std::vector<float> meshDepth(64 * 64, -1);
    DplImage image{};
    image.structSize = sizeof image, image.meshDepthM = meshDepth.data(), image.meshDepthCount = meshDepth.size();
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_NEAR(meshDepth[middle], 4.5f, 1e-3f);
    // The scene is in metres of the world too.
    std::vector<float> wall(64 * 64, 4);
    camera.sceneDepthM = wall.data(), camera.sceneDepthCount = wall.size();
    EXPECT_EQ(picture(avatar_, camera), std::vector<uint8_t>(64 * 64 * 4, 0)) << "behind the wall";
    std::fill(wall.begin(), wall.end(), 5.0f);
    EXPECT_EQ(picture(avatar_, camera), placed) << "before the wall";
}

TEST_F(TransformTest, theNearFadeIsInMetresOfTheWorld) {
    DplCamera camera = frontCamera();
    camera.viewFromWorld[11] = 0.1f, camera.viewFromWorld[7] = 0;  // 0.1 m before the origin: half faded
    StaticSplatData splat;
    splat.position = {{0, 0, 0}}, splat.rotation = {{1, 0, 0, 0}}, splat.scaleM = {Vec3f(0.1f, 0.1f, 1e-4f)}, splat.opacity = {0.95f},
    splat.sh = {1, 1, 1};
    const auto file = *writePly(splat);
    DplAvatar splats = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, file.data(), file.size(), &splats), DPL_OK) << dplGetLastError();
    const size_t middle = 4 * (32 * 64 + 32) + 3;
    const int atOne = picture(splats, camera)[middle];
    EXPECT_NEAR(atOne, 0.95 * 0.5 * 255, 4);
    for (const float s : {0.1f, 10.0f, 1000.0f}) {
        const Rows scaled = {s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0};
        ASSERT_EQ(dplSetTransform(splats, scaled.data()), DPL_OK) << dplGetLastError();
        EXPECT_NEAR(picture(splats, camera)[middle], atOne, 3) << s;
    }
    EXPECT_EQ(dplDestroyAvatar(splats), DPL_OK);
}

TEST_F(TransformTest, isKeptAndIsNoPartOfThePose) {
    ASSERT_EQ(dplSetTransform(avatar_, kTurned.data()), DPL_OK);
    const float rotations[8] = {0, 0, 0, 1, 0, 0, 0, 1}, root[3] = {1, 2, 3};
    ASSERT_EQ(dplSetPose(avatar_, rotations, 2, root), DPL_OK);
    EXPECT_EQ(transform(avatar_), kTurned);
    float read[8], readRoot[3];
    ASSERT_EQ(dplGetPose(avatar_, read, 2, readRoot), DPL_OK);
    EXPECT_TRUE(std::equal(read, read + 8, rotations) && std::equal(readRoot, readRoot + 3, root));
    ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 0.3, DPL_TRUE), DPL_OK);
    ASSERT_EQ(dplSettle(avatar_), DPL_OK);
    EXPECT_EQ(transform(avatar_), kTurned);
    DplAvatarInfo info{};
    info.structSize = sizeof info;
    ASSERT_EQ(dplGetAvatarInfo(avatar_, &info), DPL_OK);
    EXPECT_NEAR(info.restMax[1], 1.5f, 0.01f) << "avatar space";
}

TEST_F(TransformTest, trustAndWhatClothesRememberDoNotKnowOfIt) {
    AvatarData data = withCorrectives(tinyAvatar(), 3, {.motion = 2});
    sortSplats(data);
    const auto bytes = *writeAvatar(data);
    DplAvatar dressed = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &dressed), DPL_OK) << dplGetLastError();
    const auto live = [&](const float* placed) {
        const float bent[8] = {0, 0, 0, 1, 0.6f, 0, 0, 0.8f}, rest[8] = {0, 0, 0, 1, 0, 0, 0, 1};
        EXPECT_EQ(dplSetTransform(dressed, placed), DPL_OK);
        EXPECT_EQ(dplSettle(dressed), DPL_OK);
        EXPECT_EQ(dplSetPoseAtTime(dressed, rest, 2, nullptr, 0), DPL_OK);
        picture(dressed, frontCamera());
        EXPECT_EQ(dplSetPoseAtTime(dressed, bent, 2, nullptr, 100'000'000), DPL_OK);
        std::vector<uint8_t> state(8192);
        size_t size = 0;
        EXPECT_EQ(dplGetMotionState(dressed, state.data(), state.size(), &size), DPL_OK) << dplGetLastError();
        state.resize(size);
        DplPoseTrust trust{};
        trust.structSize = sizeof trust;
        EXPECT_EQ(dplGetPoseTrust(dressed, &trust, nullptr, 0), DPL_OK) << dplGetLastError();
        return std::pair(state, trust.away);
    };
    EXPECT_EQ(live(nullptr), live(kTurned.data()));
    EXPECT_EQ(dplDestroyAvatar(dressed), DPL_OK);
}

/** The light of the scene stands in avatar space: moving the avatar takes it along, turning the root turns the person in it. */
TEST_F(TransformTest, theLightOfTheSceneGoesAlong) {
    AvatarData data = tinyAvatar();
    data.light.irradiance = {0.1f, 0.4f, 0.9f};  // from the front, and more from -X
    sortSplats(data);
    const auto bytes = *writeAvatar(data);
    DplAvatar lit = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &lit), DPL_OK) << dplGetLastError();
    const auto turnRoot = [&](float rad) {
        const float rotations[8] = {0, std::sin(rad / 2), 0, std::cos(rad / 2), 0, 0, 0, 1};
        EXPECT_EQ(dplSetPose(lit, rotations, 2, nullptr), DPL_OK) << dplGetLastError();
    };
    DplCamera camera = frontCamera();
    const float fromTheSide[12] = {0, 0, -1, 3, 0, -1, 0, 1, -1, 0, 0, 5};
    std::copy_n(fromTheSide, 12, camera.viewFromWorld);
    const size_t middle = 4 * (32 * 64 + 32);
    turnRoot(0.5f);
    const std::vector<uint8_t> own = picture(lit, cameraMovedTheOtherWay(camera, kTurned, 2));
    ASSERT_EQ(dplSetTransform(lit, kTurned.data()), DPL_OK);
    EXPECT_EQ(picture(lit, camera), own);
    constexpr Rows kNotTurned = {2, 0, 0, 0.5f, 0, 2, 0, -1, 0, 0, 2, 3};
    ASSERT_EQ(dplSetTransform(lit, kNotTurned.data()), DPL_OK);
    turnRoot(0.5f + 1.5707963f);
    const std::vector<uint8_t> inTheLight = picture(lit, camera);  // the same sight of the square
    EXPECT_NEAR(inTheLight[middle + 3], own[middle + 3], 1);
    EXPECT_GT(own[middle], 0);
    EXPECT_GT(std::abs(int(inTheLight[middle]) - int(own[middle])), 40) << "but other light";
    EXPECT_EQ(dplDestroyAvatar(lit), DPL_OK);
}

TEST_F(TransformTest, jointsAndNearestDistancesAreOfTheWorld) {
    float positions[6];
    ASSERT_EQ(dplSetTransform(avatar_, kTurned.data()), DPL_OK);
    ASSERT_EQ(dplGetJointPositions(avatar_, positions, 2), DPL_OK);
    EXPECT_NEAR(positions[0], 0.5f, 1e-6f);  // the pelvis at (0, 1, 0)
    EXPECT_NEAR(positions[1], 1, 1e-6f);
    EXPECT_NEAR(positions[2], 3, 1e-6f);
    AvatarData data = tinyAvatar();
    sortSplats(data);
    for (size_t j = 0; j < data.joints.size(); ++j)
        for (const float size : {0.004f, 0.008f, 0.008f, 0.008f}) data.captureMap.sides.push_back({size, size, 3});  // front, left, ...
    const auto bytes = *writeAvatar(data);
    DplAvatar mapped = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &mapped), DPL_OK) << dplGetLastError();
    const auto nearest = [&](const std::array<float, 3>& point, const std::array<float, 3>& eye) {
        float distanceM = -1;
        EXPECT_EQ(dplGetNearestDistance(mapped, point.data(), eye.data(), 1000, 8, &distanceM), DPL_OK) << dplGetLastError();
        return distanceM;
    };
    const float front = nearest({0, 1, 0}, {0, 1, 5}), left = nearest({0, 1, 0}, {5, 1, 0});
    EXPECT_LT(front, 0.7f * left);
    ASSERT_EQ(dplSetTransform(mapped, kTurned.data()), DPL_OK);
    // It faces +X now and is twice as large; a detail is seen as large from twice as far.
    EXPECT_NEAR(nearest({0.5f, 1, 3}, {9, 1, 3}), 2 * front, 1e-4f);
    EXPECT_NEAR(nearest({0.5f, 1, 3}, {0.5f, 1, -9}), 2 * left, 1e-4f);
    EXPECT_EQ(dplDestroyAvatar(mapped), DPL_OK);
}

TEST_F(TransformTest, whatIsNoTurnWithOneScaleIsRefusedInASentence) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
    for (size_t i = 0; i < 12; ++i)
        for (const float bad : {nan, infinite, -infinite}) {
            Rows rows = kIdentity;
            rows[i] = bad;
            refused(rows, "not finite");
        }
    refused({-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, "mirrors");
    refused({-2, 0, 0, 0, 0, -2, 0, 0, 0, 0, -2, 0}, "mirrors");
    refused({1, 0.1f, 0, 0, 0, 0.995f, 0, 0, 0, 0, 1, 0}, "shears");
    refused({1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0}, "one scale");
    refused({1, 0, 0, 0, 0, 1.01f, 0, 0, 0, 0, 1, 0}, "one scale");
    refused({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}, "one scale");
    refused({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "scales by 0");
    for (const float s : {1e-30f, 0.0009f, 1001.0f, 1e30f}) refused({s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0}, "0.001 to 1000");
    refused({1, 0, 0, 2e5f, 0, 1, 0, 0, 0, 0, 1, 0}, "translation");
    for (const float s : {0.001f, 1000.0f}) {
        const Rows rows = {s, 0, 0, 1e5f, 0, s, 0, 0, 0, 0, s, -1e5f};
        EXPECT_EQ(dplSetTransform(avatar_, rows.data()), DPL_OK) << dplGetLastError();
    }
    EXPECT_EQ(dplGetTransform(avatar_, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetTransform(nullptr, kIdentity.data()), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("live avatar")) << dplGetLastError();
}

/** Rounding of a matrix in floats is no shear and no second scale. */
TEST_F(TransformTest, roundedRotationsAreTaken) {
    for (const float angle : {0.1f, 1.3f, 2.9f, 4.4f}) {
        const float c = 0.37f * std::cos(angle) * 1.0002f, s = 0.37f * std::sin(angle);
        const Rows rows = {c, 0, s, 1, 0, 0.37f, 0, 0, -s, 0, c, 0};
        EXPECT_EQ(dplSetTransform(avatar_, rows.data()), DPL_OK) << dplGetLastError();
        EXPECT_EQ(transform(avatar_), rows) << "as given";
    }
}

TEST_F(TransformTest, eachOfSeveralStandsByItsOwnAndTheNearerHidesTheOther) {
    const auto bytes = tinyFile();
    DplAvatar other = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &other), DPL_OK);
    const DplCamera camera = frontCamera();
    // A square of 0.25 m, 1 m before the other one: it covers the middle.
    const Rows nearer = {0.25f, 0, 0, 0, 0, 0.25f, 0, 0.75f, 0, 0, 0.25f, 1};
    ASSERT_EQ(dplSetTransform(other, nearer.data()), DPL_OK);
    const DplAvatar sets[2][2] = {{avatar_, other}, {other, avatar_}};
    for (const auto& set : sets) {
        std::vector<uint8_t> pixels;
        std::vector<float> depth;
        const DplImage image = imageFor(camera, pixels, &depth);
        ASSERT_EQ(dplRenderTogether(context_, set, 2, &camera, 1, &image), DPL_OK) << dplGetLastError();
        EXPECT_NEAR(depth[32 * 64 + 32], 2, 0.1f);
        EXPECT_NEAR(depth[32 * 64 + 40], 3, 0.1f) << "beside the nearer one";
    }
    EXPECT_EQ(dplDestroyAvatar(other), DPL_OK);
}

TEST_F(TransformTest, levelOfDetailGoesByTheSizeInTheWorld) {
    AvatarData data = randomAvatar(3, 12, 8);
    sortSplats(data);
    const auto bytes = *writeAvatar(data);
    DplAvatar ball = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &ball), DPL_OK) << dplGetLastError();
    const DplDetail detail{sizeof(DplDetail), 1, 0};
    ASSERT_EQ(dplSetDetail(context_, &detail), DPL_OK);
    const auto share = [&](const Rows& rows) {
        EXPECT_EQ(dplSetTransform(ball, rows.data()), DPL_OK) << dplGetLastError();
        picture(ball, frontCamera());
        DplFrameStats stats{};
        stats.structSize = sizeof stats;
        EXPECT_EQ(dplGetFrameStats(ball, &stats), DPL_OK);
        return stats.detailShare;
    };
    const float atOne = share(kIdentity), farther = share({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -6}),
                larger = share({4, 0, 0, 0, 0, 4, 0, -3, 0, 0, 4, -9});
    EXPECT_LT(farther, 0.7f * atOne);
    EXPECT_NEAR(larger, atOne, 0.01f) << "four times as large, from four times as far";
    EXPECT_EQ(dplDestroyAvatar(ball), DPL_OK);
}

}  // namespace
}  // namespace dpl::test
