// SPDX-License-Identifier: Apache-2.0
// dplSetExpression and its sisters: the face stays beside the pose, weights of zero draw the same bytes, and bad weights are refused.
#include <algorithm>
#include <array>

#include "tests/not_finite.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/format/sample_expressions.h"

namespace dpl::test {
namespace {

using FaceWeights = std::array<float, DPL_EXPRESSION_COUNT>;

class ExpressionApiTest : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        AvatarData plain = tinyAvatar();
        sortSplats(plain);
        plain_ = load(plain);
        face_ = load(withExpressions(plain, 3, 4, 0.05f));
    }
    void TearDown() override {
        EXPECT_EQ(dplDestroyAvatar(plain_), DPL_OK);
        EXPECT_EQ(dplDestroyAvatar(face_), DPL_OK);
        ApiTest::TearDown();
    }
    DplAvatar load(const AvatarData& data) {
        const auto bytes = writeAvatar(data);
        EXPECT_TRUE(bytes) << bytes.error().message;
        DplAvatar avatar = nullptr;
        EXPECT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &avatar), DPL_OK) << dplGetLastError();
        return avatar;
    }
    std::vector<uint8_t> drawn(DplAvatar avatar) {
        const DplCamera camera = frontCamera();
        std::vector<uint8_t> pixels;
        const DplImage image = imageFor(camera, pixels);
        EXPECT_EQ(dplRender(context_, avatar, &camera, 1, &image), DPL_OK) << dplGetLastError();
        EXPECT_GT(std::count_if(pixels.begin(), pixels.end(), [](uint8_t c) { return c != 0; }), 200) << "an empty picture proves nothing";
        return pixels;
    }
    DplResult set(DplAvatar avatar, const FaceWeights& weights) { return dplSetExpression(avatar, weights.data(), DPL_EXPRESSION_COUNT); }
    FaceWeights weightsOf(DplAvatar avatar) {
        FaceWeights weights;
        EXPECT_EQ(dplGetExpression(avatar, weights.data(), DPL_EXPRESSION_COUNT), DPL_OK) << dplGetLastError();
        return weights;
    }

    DplAvatar plain_ = nullptr, face_ = nullptr;
};

TEST_F(ExpressionApiTest, weightsOfZeroDrawTheSameBytesAsAnAvatarWithout) {
    const std::vector<uint8_t> neutral = drawn(plain_);
    EXPECT_TRUE(drawn(face_) == neutral);
    FaceWeights weights{};
    weights[0] = 1;
    ASSERT_EQ(set(face_, weights), DPL_OK) << dplGetLastError();
    EXPECT_TRUE(drawn(face_) != neutral) << "the face moves";
    ASSERT_EQ(set(face_, {}), DPL_OK);
    EXPECT_TRUE(drawn(face_) == neutral) << "and back";
    ASSERT_EQ(set(plain_, weights), DPL_OK) << "an avatar without expressions takes them";
    EXPECT_TRUE(drawn(plain_) == neutral);
}

TEST_F(ExpressionApiTest, theFaceStaysWhilePosesComeAndGo) {
    FaceWeights weights{};
    weights[0] = 0.75f;
    ASSERT_EQ(set(face_, weights), DPL_OK);
    const std::vector<uint8_t> smiling = drawn(face_);
    const float turned[8] = {0, 0.3f, 0, 0.954f, 0, 0, 0, 1}, rest[8] = {0, 0, 0, 1, 0, 0, 0, 1};
    ASSERT_EQ(dplSetPose(face_, turned, 2, nullptr), DPL_OK);
    EXPECT_TRUE(drawn(face_) != smiling);
    ASSERT_EQ(dplSetPose(face_, rest, 2, nullptr), DPL_OK);
    EXPECT_TRUE(drawn(face_) == smiling);
    EXPECT_EQ(weightsOf(face_), weights);
}

TEST_F(ExpressionApiTest, weightsOutOfRangeAreHeldInItAndNotANumberIsRefused) {
    FaceWeights weights{};
    weights[3] = 1.02f, weights[4] = -0.01f, weights[5] = kInfinity, weights[6] = -kInfinity, weights[7] = 0.5f;
    ASSERT_EQ(set(face_, weights), DPL_OK) << dplGetLastError();
    FaceWeights want{};
    want[3] = 1, want[5] = 1, want[7] = 0.5f;
    EXPECT_EQ(weightsOf(face_), want);
    weights[23] = kNan;
    EXPECT_EQ(set(face_, weights), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("'mouthSmileLeft' is not a number")) << dplGetLastError();
    EXPECT_EQ(weightsOf(face_), want) << "the expression before stays";
}

TEST_F(ExpressionApiTest, refusesWhatDoesNotFit) {
    FaceWeights weights{};
    EXPECT_EQ(dplSetExpression(face_, weights.data(), 51), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("there are 52")) << dplGetLastError();
    EXPECT_EQ(dplSetExpression(face_, nullptr, 52), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetExpression(nullptr, weights.data(), 52), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetExpression(face_, weights.data(), 53), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetExpression(face_, nullptr, 52), DPL_ERROR_INVALID_ARGUMENT);
    uint32_t found = 99;
    EXPECT_EQ(dplFindExpression("mouthSmileLeff", &found), DPL_ERROR_NOT_FOUND);
    EXPECT_TRUE(errorSays("did you mean 'mouthSmileLeft'")) << dplGetLastError();
    EXPECT_EQ(dplFindExpression(nullptr, &found), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplFindExpression("jawOpen", nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(found, 99u) << "outputs are written only on DPL_OK";
}

TEST_F(ExpressionApiTest, streamsGoByTheirNames) {
    const char* names[] = {"_neutral", "JawOpen", "blinkLeft"};
    const float weights[] = {1, 0.5f, 2};
    ASSERT_EQ(dplSetExpressionNamed(face_, names, weights, 3), DPL_OK) << dplGetLastError();
    FaceWeights want{};
    uint32_t jaw = 0;
    ASSERT_EQ(dplFindExpression("jawOpen", &jaw), DPL_OK);
    want[0] = 1, want[jaw] = 0.5f;  // eyeBlinkLeft is the first
    EXPECT_EQ(weightsOf(face_), want);
    EXPECT_EQ(dplSetExpressionNamed(face_, nullptr, weights, 3), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("without names")) << dplGetLastError();
    EXPECT_EQ(dplSetExpressionNamed(face_, names, nullptr, 3), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetExpressionNamed(face_, names, weights, 0x7fffffff), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetExpressionNamed(nullptr, names, weights, 3), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(weightsOf(face_), want) << "the expression before stays";
    EXPECT_EQ(dplSetExpressionNamed(face_, names, nullptr, 0), DPL_OK) << "an empty list shows nothing";
    EXPECT_EQ(weightsOf(face_), FaceWeights{});
}

TEST_F(ExpressionApiTest, aFaceMovesByItselfOnlyWhereItIsAsked) {
    const std::vector<uint8_t> neutral = drawn(face_);
    DplFaceMotion motion{};
    motion.structSize = sizeof motion;
    ASSERT_EQ(dplSetFaceMotion(face_, &motion, 5'000'000'000), DPL_OK) << dplGetLastError();
    EXPECT_TRUE(drawn(face_) == neutral) << "zeros: the same bytes";
    motion.seed = 3, motion.blinks = motion.glances = 1;
    const auto eyelid = [&](int64_t ms) {
        EXPECT_EQ(dplSetFaceMotion(face_, &motion, ms * 1'000'000), DPL_OK) << dplGetLastError();
        return weightsOf(face_)[0];  // eyeBlinkLeft
    };
    int64_t closed = 0;
    while (closed < 60'000 && eyelid(closed) < 0.9f) closed += 10;
    ASSERT_LT(closed, 60'000) << "a blink within a minute";
    const std::vector<uint8_t> blinking = drawn(face_);
    EXPECT_TRUE(blinking != neutral);
    EXPECT_TRUE(drawn(plain_) == neutral);
    EXPECT_EQ(eyelid(closed + 500), 0);
    EXPECT_TRUE(drawn(face_) != blinking);
    EXPECT_GE(eyelid(closed), 0.9f) << "any order";
    EXPECT_TRUE(drawn(face_) == blinking) << "the same bytes from the same arguments";
    motion.blinks = kNan;
    EXPECT_EQ(dplSetFaceMotion(face_, &motion, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("blinks")) << dplGetLastError();
    EXPECT_TRUE(drawn(face_) == blinking) << "what was asked before stays";
}

TEST_F(ExpressionApiTest, aStreamThatStopsFadesAndComesBack) {
    FaceWeights weights{};
    weights[0] = 1;
    ASSERT_EQ(set(face_, weights), DPL_OK);
    DplFaceMotion motion{};
    motion.structSize = sizeof motion, motion.holdS = 0.3f, motion.heardNs = 1'000'000'000;
    ASSERT_EQ(dplSetFaceMotion(face_, &motion, 1'200'000'000), DPL_OK);
    EXPECT_EQ(weightsOf(face_), weights);
    ASSERT_EQ(dplSetFaceMotion(face_, &motion, 1'600'000'000), DPL_OK);
    EXPECT_EQ(weightsOf(face_), FaceWeights{}) << "silent for 0.3 s, faded within 0.25 s";
    motion.heardNs = 1'650'000'000;
    ASSERT_EQ(dplSetFaceMotion(face_, &motion, 1'660'000'000), DPL_OK);
    EXPECT_EQ(weightsOf(face_), weights) << "it speaks again";
}

TEST_F(ExpressionApiTest, namesAreARKitsAndSayWhatIsDrawn) {
    uint32_t drawn = 0;
    for (uint32_t e = 0; e < DPL_EXPRESSION_COUNT; ++e) {
        DplExpressionInfo info{};
        info.structSize = sizeof info;
        ASSERT_EQ(dplGetExpressionInfo(face_, e, &info), DPL_OK) << dplGetLastError();
        uint32_t found = 99;
        EXPECT_EQ(dplFindExpression(info.name, &found), DPL_OK);
        EXPECT_EQ(found, e);
        drawn += info.drawn == DPL_TRUE;
        ASSERT_EQ(dplGetExpressionInfo(plain_, e, &info), DPL_OK);
        EXPECT_EQ(info.drawn, DPL_FALSE);
    }
    EXPECT_EQ(drawn, 4u);
    DplExpressionInfo info{};
    info.structSize = sizeof info;
    EXPECT_EQ(dplGetExpressionInfo(face_, 52, &info), DPL_ERROR_NOT_FOUND);
}

}  // namespace
}  // namespace dpl::test
