// SPDX-License-Identifier: Apache-2.0
// Clothes that remember, through the C API: when they do, when they do not, and that a state can be saved.
#include <algorithm>
#include <cmath>

#include "tests/not_finite.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

class MotionApiTest : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        AvatarData data = withCorrectives(tinyAvatar(), 3, {.offsetM = 0.2f, .reach = 0.01f, .motion = 4});
        data.correctives.motion.movedFromRad = 0.01f, data.correctives.motion.movedToRad = 0.02f;
        data.correctives.motion.holdsS = {0, 60};
        for (Vec2f& range : data.correctives.motion.rangeRad) range = Vec2f(0.01f, 2);
        for (Vec4f& still : data.correctives.motion.still) still = Vec4f(0, 0, 0, 1);
        sortSplats(data);
        const auto bytes = writeAvatar(data);
        ASSERT_TRUE(bytes) << bytes.error().message;
        ASSERT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &person_), DPL_OK) << dplGetLastError();
    }
    void TearDown() override {
        EXPECT_EQ(dplDestroyAvatar(person_), DPL_OK);
        ApiTest::TearDown();
    }
    /** Both joints, the second turned about x by the angle whose half has this sine. */
    std::vector<float> pose(float sine) const { return {0, 0, 0, 1, sine, 0, 0, std::sqrt(1 - sine * sine)}; }
    std::vector<uint8_t> drawn() {
        const DplCamera camera = frontCamera();
        std::vector<uint8_t> pixels;
        const DplImage image = imageFor(camera, pixels);
        EXPECT_EQ(dplRender(context_, person_, &camera, 1, &image), DPL_OK) << dplGetLastError();
        EXPECT_GT(std::count_if(pixels.begin(), pixels.end(), [](uint8_t c) { return c != 0; }), 200) << "an empty picture proves nothing";
        return pixels;
    }
    std::vector<uint8_t> drawnPlain(float sine) {
        EXPECT_EQ(dplSetPose(person_, pose(sine).data(), 2, nullptr), DPL_OK) << dplGetLastError();
        return drawn();
    }
    std::vector<uint8_t> drawnAt(float sine, int64_t timeNs) {
        EXPECT_EQ(dplSetPoseAtTime(person_, pose(sine).data(), 2, nullptr, timeNs), DPL_OK) << dplGetLastError();
        return drawn();
    }
    std::vector<uint8_t> state() {
        size_t size = 0;
        EXPECT_EQ(dplGetMotionState(person_, nullptr, 0, &size), DPL_OK) << dplGetLastError();
        std::vector<uint8_t> bytes(size);
        EXPECT_EQ(dplGetMotionState(person_, bytes.data(), size, &size), DPL_OK) << dplGetLastError();
        return bytes;
    }

    DplAvatar person_ = nullptr;
};

TEST_F(MotionApiTest, aPoseWithATimeRemembersAndAPoseWithoutDoesNot) {
    const std::vector<uint8_t> rest = drawnPlain(0);
    EXPECT_TRUE(drawnAt(0, 0) == rest) << "nothing has happened yet";
    EXPECT_TRUE(drawnAt(0.6f, kSecond) != rest);
    const std::vector<uint8_t> after = drawnAt(0, 2 * kSecond);
    EXPECT_TRUE(after != rest) << "the pose is that of the start, and its clothes are not";
    EXPECT_TRUE(drawn() == after) << "a second picture of the same pose";
    EXPECT_TRUE(drawnAt(0, 2 * kSecond) == after) << "the same pose for the same time";
    EXPECT_TRUE(drawnPlain(0) == rest) << "the same pose, the same bytes";
}

TEST_F(MotionApiTest, aPoseThatIsHeldBackKeepsItsTime) {
    drawnAt(0, 0);
    drawnAt(0.6f, kSecond);
    const std::vector<uint8_t> want = drawnAt(0, 2 * kSecond);
    ASSERT_EQ(dplSettle(person_), DPL_OK) << dplGetLastError();
    EXPECT_TRUE(drawnAt(0, 3 * kSecond) != want) << "forgotten";
    ASSERT_EQ(dplSetPoseAtTime(person_, pose(0.6f).data(), 2, nullptr, 4 * kSecond), DPL_OK) << dplGetLastError();
    ASSERT_EQ(dplHoldPose(person_, 1e3f), DPL_OK) << dplGetLastError();  // so far that it changes nothing
    drawn();
    EXPECT_TRUE(drawnAt(0, 5 * kSecond) == want);
}

TEST_F(MotionApiTest, allViewsOfAPictureShowOneState) {
    const DplCamera cameras[2] = {frontCamera(), frontCamera()};
    const auto drawnTwice = [&](float sine, int64_t timeNs) {
        EXPECT_EQ(dplSetPoseAtTime(person_, pose(sine).data(), 2, nullptr, timeNs), DPL_OK) << dplGetLastError();
        std::vector<uint8_t> left, right;
        const DplImage images[2] = {imageFor(cameras[0], left), imageFor(cameras[1], right)};
        EXPECT_EQ(dplRender(context_, person_, cameras, 2, images), DPL_OK) << dplGetLastError();
        EXPECT_TRUE(left == right) << "at " << timeNs << " ns";
        return left;
    };
    std::vector<std::vector<uint8_t>> alone, pairs;
    for (const float sine : {0.0f, 0.6f, 0.1f, 0.0f}) alone.push_back(drawnAt(sine, int64_t(alone.size()) * kSecond / 5));
    const std::vector<uint8_t> want = state();
    ASSERT_EQ(dplSettle(person_), DPL_OK) << dplGetLastError();
    for (const float sine : {0.0f, 0.6f, 0.1f, 0.0f}) pairs.push_back(drawnTwice(sine, int64_t(pairs.size()) * kSecond / 5));
    EXPECT_TRUE(pairs == alone) << "a second view takes no second step";
    EXPECT_TRUE(state() == want);
    EXPECT_TRUE(alone.back() != alone.front()) << "there is something to remember";
}

/** Four rates that all draw at each sixth of a second, scored like evidence: against one picture that none of them draws. */
TEST_F(MotionApiTest, picturesOfEveryRateScoreAlikeToATenthOfADecibel) {
    const auto sineAt = [](double timeS) { return float(0.35 * std::sin(5 * timeS) * std::sin(1.3 * timeS)); };
    const std::vector<uint8_t> truth = drawnPlain(0.2f);
    const auto scoreDb = [&](const std::vector<uint8_t>& picture) {
        double squares = 0;
        for (size_t i = 0; i < picture.size(); ++i) squares += std::pow(double(picture[i]) - double(truth[i]), 2);
        return 10 * std::log10(255 * 255 * double(picture.size()) / squares);
    };
    std::vector<std::vector<double>> scores;
    for (const int rate : {30, 72, 90, 120}) {
        ASSERT_EQ(dplSettle(person_), DPL_OK) << dplGetLastError();
        scores.emplace_back();
        for (int k = 0; k <= 2 * rate; ++k) {
            const std::vector<uint8_t> picture = drawnAt(sineAt(double(k) / rate), int64_t(k) * kSecond / rate);
            if (k > 0 && 6 * k % rate == 0) scores.back().push_back(scoreDb(picture));
        }
    }
    ASSERT_EQ(scores[0].size(), 12u);
    double forgotten = 0;
    for (size_t i = 0; i < scores[0].size(); ++i) {
        for (const std::vector<double>& rate : scores) EXPECT_NEAR(rate[i], scores[0][i], 0.1) << "picture " << i;
        forgotten = std::max(forgotten, std::abs(scoreDb(drawnPlain(sineAt(double(i + 1) / 6))) - scores[0][i]));
    }
    EXPECT_GT(forgotten, 0.5) << "memory must show, or nothing is compared";
}

TEST_F(MotionApiTest, settledClothesAreThoseOfThePoseAlone) {
    const std::vector<uint8_t> rest = drawnPlain(0);
    drawnAt(0.6f, 0);
    EXPECT_TRUE(drawnAt(0, kSecond) != rest);
    ASSERT_EQ(dplSettle(person_), DPL_OK) << dplGetLastError();
    EXPECT_TRUE(drawn() == rest);
    EXPECT_TRUE(drawnAt(0, 2 * kSecond) == rest);
}

TEST_F(MotionApiTest, posesThatWereNeverDrawnLeaveNoTrace) {
    const std::vector<uint8_t> rest = drawnPlain(0);
    drawnAt(0, 0);
    ASSERT_EQ(dplSetPoseAtTime(person_, pose(0.6f).data(), 2, nullptr, kSecond), DPL_OK);
    EXPECT_TRUE(drawnAt(0, 2 * kSecond) == rest);
}

TEST_F(MotionApiTest, aSavedStateGoesOnAlikeInAnotherAvatar) {
    drawnAt(0.6f, 0), drawnAt(0.3f, kSecond);
    const std::vector<uint8_t> saved = state();
    const std::vector<uint8_t> want = drawnAt(0.1f, 2 * kSecond);
    drawnPlain(0), drawnAt(0.5f, 900 * kSecond);
    ASSERT_EQ(dplSetMotionState(person_, saved.data(), saved.size()), DPL_OK) << dplGetLastError();
    EXPECT_TRUE(drawnAt(0.1f, 2 * kSecond) == want);
    EXPECT_EQ(dplSetMotionState(avatar_, saved.data(), saved.size()), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("another avatar")) << dplGetLastError();
    EXPECT_TRUE(drawn() == want) << "a refused state changes nothing";
}

TEST_F(MotionApiTest, refusesWhatDoesNotFit) {
    size_t size = 7;
    std::vector<uint8_t> bytes = state();
    EXPECT_EQ(dplGetMotionState(person_, bytes.data(), bytes.size() - 1, &size), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(size, 7u) << "outputs are written only on DPL_OK";
    EXPECT_EQ(dplGetMotionState(person_, bytes.data(), bytes.size(), nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetMotionState(person_, nullptr, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetMotionState(person_, bytes.data(), 3), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSettle(nullptr), DPL_ERROR_INVALID_ARGUMENT);
    const std::vector<uint8_t> before = drawnAt(0.3f, 0);
    const float bad[8] = {0, 0, 0, 1, kNan, 0, 0, 1};
    EXPECT_EQ(dplSetPoseAtTime(person_, bad, 2, nullptr, kSecond), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(drawn() == before) << "pose and time stay";
}

TEST_F(MotionApiTest, stiffnessStaysWhilePosesComeAndGo) {
    const std::vector<uint8_t> learned = drawnPlain(0.6f);
    ASSERT_EQ(dplSetClothStiffness(person_, 3), DPL_OK) << dplGetLastError();
    const std::vector<uint8_t> stiffer = drawn();
    EXPECT_TRUE(stiffer != learned) << "the same pose is drawn anew";
    EXPECT_TRUE(drawnAt(0.6f, 0) == stiffer);
    EXPECT_TRUE(drawnPlain(0.6f) == stiffer);
    ASSERT_EQ(dplSetPoseFromClip(person_, 0, 0.9, DPL_FALSE), DPL_OK);
    const std::vector<uint8_t> stiffClip = drawn();
    const std::vector<uint8_t> saved = state();
    ASSERT_EQ(dplSetClothStiffness(person_, 1), DPL_OK) << dplGetLastError();
    EXPECT_TRUE(state() == saved) << "what is remembered does not know of it";
    EXPECT_TRUE(drawn() != stiffClip);
    EXPECT_TRUE(drawnPlain(0.6f) == learned) << "1 is as learned, to the byte";
}

TEST_F(MotionApiTest, refusesAStiffnessThatIsNone) {
    ASSERT_EQ(dplSetClothStiffness(person_, 3), DPL_OK) << dplGetLastError();
    const std::vector<uint8_t> stiffer = drawnPlain(0.6f);
    for (const float bad : {-1e-6f, 100.01f, kNan, kInfinity, -kInfinity}) {
        EXPECT_EQ(dplSetClothStiffness(person_, bad), DPL_ERROR_INVALID_ARGUMENT) << bad;
        EXPECT_TRUE(errorSays("from 0 to 100, and 1 is as learned")) << dplGetLastError();
    }
    EXPECT_EQ(dplSetClothStiffness(nullptr, 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(drawn() == stiffer) << "the stiffness before stays";
    EXPECT_EQ(dplSetClothStiffness(person_, 0), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplSetClothStiffness(person_, 100), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplSetClothStiffness(avatar_, 3), DPL_OK) << "an avatar whose clothes learned no motion takes it";
}

TEST_F(MotionApiTest, aClipIsAFunctionOfItsTimeInAnyOrder) {
    std::vector<std::vector<uint8_t>> forward;
    for (int k = 0; k <= 6; ++k) {
        ASSERT_EQ(dplSetPoseFromClip(person_, 0, 0.15 * k, DPL_FALSE), DPL_OK) << dplGetLastError();
        forward.push_back(drawn());
    }
    drawnAt(0.6f, kSecond);
    for (int k = 6; k >= 0; --k) {
        ASSERT_EQ(dplSetPoseFromClip(person_, 0, 0.15 * k, DPL_FALSE), DPL_OK);
        EXPECT_TRUE(drawn() == forward[size_t(k)]) << k;
    }
    EXPECT_TRUE(forward[6] != forward[0]);
}

}  // namespace
}  // namespace dpl::test
