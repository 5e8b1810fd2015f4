// SPDX-License-Identifier: Apache-2.0
// Eyes that the pose turns and eyes that expressions move: the pose comes first, and no eye turns farther than its limit.
#include "sdk/motion/face_gaze.h"

#include <gtest/gtest.h>

#include "sdk/format/expression_names.h"
#include "sdk/motion/gaze.h"
#include "tests/unit/avatar/rigs.h"

namespace dpl {
namespace {

size_t expressionAt(const char* name) {
    return *expressionOf(name);
}

class FaceGazeTest : public ::testing::Test {
protected:
    void SetUp() override {
        avatar_.joints = test::personRig(0.8f);
        const int32_t head = int32_t(test::jointOf(avatar_.joints, "head"));
        left_ = avatar_.joints.size(), right_ = left_ + 1;
        avatar_.joints.push_back({"left_eye", head, {0.03f, 1.615f, 0.095f}, "leftEye"});
        avatar_.joints.push_back({"right_eye", head, {-0.03f, 1.615f, 0.095f}, "rightEye"});
        avatar_.mesh.jointIndices = {glm::u16vec4(uint16_t(head), 0, 0, 0)};
        avatar_.mesh.jointWeights = {Vec4f(1, 0, 0, 0)};
        pose_ = Pose::rest(avatar_.joints.size());
    }
    void haveEyeballs() {
        avatar_.mesh.jointIndices.push_back(glm::u16vec4(uint16_t(left_), 0, 0, 0));
        avatar_.mesh.jointWeights.push_back(Vec4f(1, 0, 0, 0));
    }
    /** To the subject's left, and up. */
    void turnEyes(float leftRad, float upRad) {
        pose_.localRotations[left_] = pose_.localRotations[right_] =
            glm::angleAxis(leftRad, Vec3f(0, 1, 0)) * glm::angleAxis(-upRad, Vec3f(1, 0, 0));
    }
    ExpressionWeights shown(const ExpressionWeights& weights) { return withGaze(weights, FaceEyes::of(avatar_), pose_.localRotations); }

    AvatarData avatar_;
    Pose pose_;
    size_t left_ = 0, right_ = 0;
};

TEST_F(FaceGazeTest, paintedEyesShowWhereThePoseTurnsThem) {
    EXPECT_FALSE(FaceEyes::of(avatar_).carrySkin);
    EXPECT_EQ(shown({}), ExpressionWeights{}) << "at rest: the same bytes";
    turnEyes(0.3f, 0);
    ExpressionWeights face = shown({});
    EXPECT_NEAR(face[expressionAt("eyeLookOutLeft")], 0.5f, 1e-5f) << "half of 0.6 rad";
    EXPECT_NEAR(face[expressionAt("eyeLookInRight")], 0.5f, 1e-5f) << "both to the same side";
    EXPECT_EQ(face[expressionAt("eyeLookInLeft")] + face[expressionAt("eyeLookOutRight")], 0);
    ExpressionWeights set{};
    set[expressionAt("eyeLookOutLeft")] = 0.2f, set[expressionAt("jawOpen")] = 0.7f;
    face = shown(set);
    EXPECT_NEAR(face[expressionAt("eyeLookOutLeft")], 0.7f, 1e-5f) << "what is set comes on top";
    EXPECT_EQ(face[expressionAt("jawOpen")], 0.7f);
    set[expressionAt("eyeLookOutLeft")] = 0.9f;
    EXPECT_EQ(shown(set)[expressionAt("eyeLookOutLeft")], 1) << "held at the limit";
    turnEyes(0, -0.2f);
    EXPECT_NEAR(shown({})[expressionAt("eyeLookDownRight")], 0.5f, 1e-5f) << "half of 0.4 rad";
    turnEyes(0, 0.5f);
    EXPECT_EQ(shown({})[expressionAt("eyeLookUpLeft")], 1);
}

TEST_F(FaceGazeTest, eyeballsThatThePoseHasTurnedTakeNoMoreThanTheirLimitLeaves) {
    haveEyeballs();
    EXPECT_TRUE(FaceEyes::of(avatar_).carrySkin);
    ExpressionWeights set{};
    set[expressionAt("eyeLookOutLeft")] = set[expressionAt("eyeLookInRight")] = 0.8f, set[expressionAt("eyeBlinkLeft")] = 1;
    EXPECT_EQ(shown(set), set);
    for (const float turned : {0.06f, 0.15f, 0.3f, 0.45f, 0.6f, 0.9f}) {
        turnEyes(turned, 0);
        const ExpressionWeights face = shown(set);
        EXPECT_LE(turned + face[expressionAt("eyeLookOutLeft")] * kUsualEyeLimitRad.x, std::max(kUsualEyeLimitRad.x, turned) + 1e-5f)
            << turned;
        EXPECT_LE(face[expressionAt("eyeLookOutLeft")], 0.8f);
        EXPECT_EQ(face[expressionAt("eyeBlinkLeft")], 1) << "lids are not the eyes'";
    }
    turnEyes(-0.5f, 0);
    EXPECT_EQ(shown(set), set) << "back from the other side there is room";
    EXPECT_EQ(shown({}), ExpressionWeights{}) << "the joints show their turn themselves";
}

TEST_F(FaceGazeTest, aRigWithoutEyesKeepsItsFace) {
    avatar_.joints.resize(left_);
    pose_ = Pose::rest(left_);
    ExpressionWeights set{};
    set[expressionAt("eyeLookUpLeft")] = 1;
    EXPECT_EQ(shown(set), set);
}

}  // namespace
}  // namespace dpl
