// SPDX-License-Identifier: Apache-2.0
// The coach's list of missing moves, on poses of the built-in skeleton that show each move.
#include "reconstruction/judging/coach/moves.h"

#include <array>
#include <map>

#include <gtest/gtest.h>

#include "reconstruction/judging/coach/move_poses.h"
#include "reconstruction/subject/sample/subject.h"
#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

class Moves : public testing::Test {
protected:
    static void SetUpTestSuite() {
        Jobs jobs;
        joints_ = makeSubject(1, jobs).joints;
    }
    /** The rest pose with some bones turned by degrees about the axes at rest: x left, y up, z front. */
    static Pose turned(const std::map<std::string, Vec3f>& degrees) {
        Pose pose = Pose::rest(joints_.size());
        const BoneMap bones = bonesOf(joints_);
        for (const auto& [bone, angle] : degrees) pose.localRotations[findBone(bones, bone).value()] = Quatf(glm::radians(angle));
        return pose;
    }
    /** Poses that show all moves but `without`. */
    static std::vector<Pose> film(const std::string& without) {
        std::vector<Pose> poses{turned({})};
        const auto add = [&](const std::string& move, std::vector<Pose> shown) {
            if (move != without) poses.insert(poses.end(), shown.begin(), shown.end());
        };
        add("raise", {turned({{"leftUpperArm", {0, 0, 100}}, {"rightUpperArm", {0, 0, -100}}})});
        add("elbows", {turned({{"leftLowerArm", {0, -90, 0}}, {"rightLowerArm", {0, 90, 0}}})});
        add("knees", {turned({{"leftUpperLeg", {-70, 0, 0}}, {"rightUpperLeg", {-60, 0, 0}}})});
        add("bow", {turned({{"spine", {50, 0, 0}}})});
        add("twist", {turned({{"spine", {0, 25, 0}}}), turned({{"spine", {0, -25, 0}}})});
        add("head", {turned({{"head", {0, 35, 0}}}), turned({{"head", {0, -35, 0}}})});
        add("steps", {turned({{"leftUpperLeg", {-25, 0, 0}}, {"rightUpperLeg", {15, 0, 0}}}),
                      turned({{"rightUpperLeg", {-25, 0, 0}}, {"leftUpperLeg", {15, 0, 0}}})});
        add("turns", {turned({{"hips", {0, 40, 0}}}), turned({{"hips", {0, -40, 0}}})});
        return poses;
    }
    static std::vector<JointData> joints_;
};
std::vector<JointData> Moves::joints_;

TEST_F(Moves, twoWalksEndWhereTheyBeginAndStandOnTheFloor) {
    const std::vector<ClipData> walks = walkClips(joints_);
    ASSERT_EQ(walks.size(), 2u);
    EXPECT_EQ(walks[0].name, "walk");
    EXPECT_EQ(walks[1].name, "stroll");
    std::array<float, 2> most{};
    for (size_t w = 0; w < walks.size(); ++w) {
        ASSERT_FALSE(walks[w].channels.empty());
        for (const ClipChannel& channel : walks[w].channels) {
            ASSERT_EQ(channel.rotations.size(), walks[w].timesS.size());
            EXPECT_GT(std::abs(glm::dot(channel.rotations.front(), channel.rotations.back())), 0.999999f);
            for (const Quatf& q : channel.rotations) most[w] = std::max(most[w], glm::angle(q));
        }
        EXPECT_NEAR(walks[w].rootTranslations.front().y, walks[w].rootTranslations.back().y, 1e-6);
    }
    EXPECT_LT(most[1], most[0]) << "a stroll has shorter steps";
    EXPECT_TRUE(walkClips(std::vector<JointData>(2)).empty()) << "a rig without legs";
}

TEST_F(Moves, aFilmOfAllMovesLacksNone) {
    EXPECT_TRUE(missingMoves(joints_, film("")).empty()) << movesToFilm(joints_, film(""))->sentence;
    EXPECT_FALSE(movesToFilm(joints_, film("")));
}

TEST_F(Moves, theMoveThatIsNotFilmedIsNamed) {
    const std::map<std::string, std::string> words = {{"raise", "raise both arms to the side and up"},
                                                      {"elbows", "bend both elbows"},
                                                      {"knees", "lift one knee and then the other"},
                                                      {"twist", "twist to both sides"},
                                                      {"head", "turn the head to both sides"},
                                                      {"steps", "walk on the spot with long steps and swinging arms"},
                                                      {"turns", "turn quickly on the spot to both sides"}};
    for (const auto& [move, sentence] : words) {
        const std::vector<std::string_view> missing = missingMoves(joints_, film(move));
        ASSERT_EQ(missing.size(), 1u) << move;
        EXPECT_EQ(missing[0], sentence);
        EXPECT_EQ(movesToFilm(joints_, film(move))->sentence,
                  "Film these moves too: " + sentence + ". Clothes learn only from moves that are filmed");
    }
}

TEST_F(Moves, aBowIsABentSpineOrTurnedHips) {
    std::vector<Pose> straight;
    for (const Pose& pose : film("bow")) {
        const BoneMap bones = bonesOf(joints_);
        const auto both = [&](const char* bone) { return glm::angle(pose.localRotations[*findBone(bones, bone)]) > 0.9f; };
        if (!(both("leftUpperLeg") && both("rightUpperLeg"))) straight.push_back(pose);
    }
    straight.push_back(turned({{"leftUpperLeg", {-70, 0, 0}}})), straight.push_back(turned({{"rightUpperLeg", {-70, 0, 0}}}));
    ASSERT_EQ(missingMoves(joints_, straight), std::vector<std::string_view>{"bow"});
    straight.push_back(turned({{"hips", {50, 0, 0}}, {"leftUpperLeg", {-50, 0, 0}}, {"rightUpperLeg", {-50, 0, 0}}}));
    EXPECT_TRUE(missingMoves(joints_, straight).empty());
}

TEST_F(Moves, oneSideIsNotBoth) {
    std::vector<Pose> poses = film("twist");
    poses.push_back(turned({{"spine", {0, 25, 0}}}));
    EXPECT_EQ(missingMoves(joints_, poses), std::vector<std::string_view>{"twist to both sides"});
}

TEST_F(Moves, headingsCountWhereverUpIs) {
    std::vector<Pose> poses = film("turns");
    const size_t hips = findBone(bonesOf(joints_), "hips").value();
    const Quatf world(glm::radians(Vec3f(70, 20, 40)));
    for (Pose& pose : poses) pose.localRotations[hips] = world * pose.localRotations[hips];
    EXPECT_EQ(missingMoves(joints_, poses), std::vector<std::string_view>{"turn quickly on the spot to both sides"});
    for (const float yaw : {170.0f, 235.0f}) {
        poses.push_back(turned({}));
        poses.back().localRotations[hips] = world * Quatf(glm::radians(Vec3f(0, yaw, 0)));
    }
    EXPECT_TRUE(missingMoves(joints_, poses).empty());
}

TEST_F(Moves, withoutMovingFramesAllMovesAreAskedFor) {
    EXPECT_EQ(missingMoves(joints_, {}).size(), 8u);
    const std::string sentence = movesToFilm(joints_, {})->sentence;
    EXPECT_TRUE(sentence.starts_with("Film the moves while you walk round: raise both arms")) << sentence;
    EXPECT_NE(sentence.find(" and turn quickly on the spot to both sides. Without"), std::string::npos) << sentence;
}

TEST_F(Moves, bonesWithoutNamesAskForNothing) {
    std::vector<JointData> chain(3);
    chain[1].parent = 0, chain[2].parent = 1;
    chain[1].restPosition = {0, 1, 0}, chain[2].restPosition = {0, 2, 0};
    EXPECT_FALSE(movesToFilm(chain, std::vector<Pose>{Pose::rest(3)}));
}

}  // namespace
}  // namespace dpl
