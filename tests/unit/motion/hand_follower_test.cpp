// SPDX-License-Identifier: Apache-2.0
// An avatar follows a head and two hands: directions, sides, missing joints. The avatar's joints are placed again in double.
#include "sdk/motion/hand_follower.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <random>

#include "sdk/motion/pose_fade.h"

namespace dpl {
namespace {

using glm::dquat;
using glm::dvec3;

constexpr double kPi = 3.14159265358979, kReachM = 0.53;
constexpr size_t kThumbMetacarpal = 2, kIndexIntermediate = 8, kIndexDistal = 9;
const Vec3f kRoot(0.1f, 0.02f, -0.2f);

/** Between two rotations, radians. */
double angleBetween(const dquat& a, const dquat& b) {
    const dquat d = a * glm::conjugate(b);
    return 2 * std::atan2(glm::length(dvec3(d.x, d.y, d.z)), std::abs(d.w));
}

/** A person in T-pose: palms down, thumbs ahead, 1.7 m. */
std::vector<JointData> person() {
    std::vector<JointData> joints = {{"hips", -1, {0, 1, 0}, "hips"},
                                     {"spine", 0, {0, 1.2f, 0}, "spine"},
                                     {"neck", 1, {0, 1.5f, 0}, "neck"},
                                     {"head", 2, {0, 1.58f, 0}, "head"}};
    const auto add = [&](int parent, Vec3f at, std::string bone) {
        joints.push_back({bone, parent, at, bone});
        return int(joints.size()) - 1;
    };
    for (const bool left : {true, false}) {
        const float s = left ? 1.0f : -1.0f;
        const std::string side = left ? "left" : "right";
        const int upper = add(1, {0.2f * s, 1.45f, 0}, side + "UpperArm"), lower = add(upper, {0.48f * s, 1.45f, 0}, side + "LowerArm");
        const int hand = add(lower, {0.73f * s, 1.45f, 0}, side + "Hand");
        const struct {
            const char* finger;
            float z;
        } fingers[] = {{"Index", 0.03f}, {"Middle", 0}, {"Ring", -0.02f}, {"Little", -0.04f}};
        for (const auto& [finger, z] : fingers) {
            const int proximal = add(hand, {0.82f * s, 1.45f, z}, side + finger + "Proximal");
            const int middle = add(proximal, {0.86f * s, 1.45f, z}, side + finger + "Intermediate");
            add(middle, {0.885f * s, 1.45f, z}, side + finger + "Distal");
        }
        const int thumb = add(hand, {0.75f * s, 1.44f, 0.03f}, side + "ThumbMetacarpal");
        add(add(thumb, {0.78f * s, 1.43f, 0.06f}, side + "ThumbProximal"), {0.80f * s, 1.42f, 0.08f}, side + "ThumbDistal");
    }
    return joints;
}

/** Where joints are and how they are turned since rest, in double. */
struct Placed {
    std::vector<dquat> world;
    std::vector<dvec3> at;
};

class HandFollowerTest : public testing::Test {
protected:
    /** Poses the person: `base_` is the pose beneath. */
    void pose(const HeadAndHands& person) {
        pose_.localRotations = base_, pose_.rootTranslation = kRoot;
        std::fill(driven_.begin(), driven_.end(), uint8_t(0));
        follower_.pose(person, pose_, driven_);
        placed_ = {};
        for (size_t j = 0; j < joints_.size(); ++j) {
            const int parent = joints_[j].parent;
            const dquat above = parent < 0 ? dquat(1, 0, 0, 0) : placed_.world[size_t(parent)];
            placed_.world.push_back(glm::normalize(above * dquat(pose_.localRotations[j])));
            placed_.at.push_back(parent < 0 ? dvec3(joints_[j].restPosition + kRoot)
                                            : placed_.at[size_t(parent)] +
                                                  above * dvec3(joints_[j].restPosition - joints_[size_t(parent)].restPosition));
        }
    }
    size_t find(const std::string& bone) const {
        for (size_t j = 0; j < joints_.size(); ++j)
            if (joints_[j].humanoidBone == bone) return j;
        ADD_FAILURE() << bone;
        return 0;
    }
    /** The axes of OpenXR's wrist on the hand at rest, by the picture of a T-pose: -z along the arm, y up. */
    static dquat restHand(size_t side) { return glm::angleAxis((side == 0 ? -1 : 1) * kPi / 2, dvec3(0, 1, 0)); }
    /** Gives a person a hand whose joints all have the wrist's rotation. */
    static void giveHand(HeadAndHands& person, size_t side, const dquat& turned, const dvec3& wrist) {
        for (size_t j = 0; j < kHandJoints; ++j) {
            person.rotations[handJoint(side, j)] = Quatf(turned * restHand(side));
            person.positions[handJoint(side, j)] = Vec3f(wrist);
            person.tracked[handJoint(side, j)] = 1;
        }
    }
    static HeadAndHands nobody() {
        HeadAndHands person;
        person.rotations.fill(Quatf(1, 0, 0, 0)), person.positions.fill(Vec3f(0));
        return person;
    }

    std::vector<JointData> joints_ = person();
    HandFollower follower_{joints_};
    std::vector<Quatf> base_ = std::vector<Quatf>(joints_.size(), Quatf(1, 0, 0, 0));
    Pose pose_;
    std::vector<uint8_t> driven_ = std::vector<uint8_t>(joints_.size());
    Placed placed_;
};

struct Tracked {
    size_t joint;
    const char *bone, *next;
};
constexpr Tracked kTracked[] = {{2, "ThumbMetacarpal", "ThumbProximal"},      {3, "ThumbProximal", "ThumbDistal"},
                                {7, "IndexProximal", "IndexIntermediate"},    {8, "IndexIntermediate", "IndexDistal"},
                                {12, "MiddleProximal", "MiddleIntermediate"}, {18, "RingIntermediate", "RingDistal"},
                                {22, "LittleProximal", "LittleIntermediate"}};

TEST_F(HandFollowerTest, wristsAndFingersAreWhereTheUsersAre) {
    constexpr unsigned kSeed = 5;
    std::mt19937 random(kSeed);
    std::normal_distribution<double> normal(0, 1);
    const auto some = [&](double radians) {
        return glm::angleAxis(radians * normal(random), glm::normalize(dvec3(normal(random), normal(random), normal(random))));
    };
    int within = 0;
    for (int n = 0; n < 50; ++n) {
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", pose " + std::to_string(n));
        for (Quatf& q : base_) q = Quatf(some(0.2));
        HeadAndHands user = nobody();
        for (size_t side = 0; side < 2; ++side) {
            const dvec3 wrist{(side == 0 ? 0.3 : -0.3) + 0.05 * normal(random), 1.4 + 0.05 * normal(random), 0.2 + 0.05 * normal(random)};
            giveHand(user, side, some(0.5), wrist);
            for (size_t j = kThumbMetacarpal; j < kHandJoints; ++j) {
                Quatf& q = user.rotations[handJoint(side, j)];
                q = Quatf(dquat(q) * some(0.4));
            }
        }
        pose(user);
        for (size_t side = 0; side < 2; ++side) {
            const std::string name = side == 0 ? "left" : "right";
            const size_t wrist = find(name + "Hand");
            const size_t tracked = handJoint(side, kWrist);
            EXPECT_LT(angleBetween(placed_.world[wrist] * restHand(side), dquat(user.rotations[tracked])), 1e-5);
            const double tooFar = glm::distance(placed_.at[find(name + "UpperArm")], dvec3(user.positions[tracked])) - kReachM;
            EXPECT_NEAR(glm::distance(placed_.at[wrist], dvec3(user.positions[tracked])), std::max(0.0, tooFar), 1e-4);
            within += tooFar < 0;
            for (const Tracked& finger : kTracked) {
                const dvec3 bone = placed_.at[find(name + finger.next)] - placed_.at[find(name + finger.bone)];
                const dvec3 wanted = dquat(user.rotations[handJoint(side, finger.joint)]) * dvec3(0, 0, -1);
                EXPECT_LT(glm::distance(glm::normalize(bone), wanted), 1e-5) << name << finger.bone;
            }
        }
    }
    EXPECT_GT(within, 50) << "of 100 wrists";
}

TEST_F(HandFollowerTest, aBentFingerIsBentByThatAngle) {
    HeadAndHands user = nobody();
    for (size_t side = 0; side < 2; ++side) {
        giveHand(user, side, dquat(1, 0, 0, 0), {side == 0 ? 0.7 : -0.7, 1.45, 0});
        // Towards the palm: about the wrist's x axis, down.
        const dquat bent = restHand(side) * glm::angleAxis(-kPi / 3, dvec3(1, 0, 0));
        for (const size_t joint : {kIndexIntermediate, kIndexDistal}) user.rotations[handJoint(side, joint)] = Quatf(bent);
    }
    pose(user);
    const dquat left = glm::angleAxis(-kPi / 3, dvec3(0, 0, 1)), right = glm::angleAxis(kPi / 3, dvec3(0, 0, 1));
    EXPECT_LT(angleBetween(dquat(pose_.localRotations[find("leftIndexIntermediate")]), left), 1e-5);
    EXPECT_LT(angleBetween(dquat(pose_.localRotations[find("rightIndexIntermediate")]), right), 1e-5);
    EXPECT_LT(angleBetween(dquat(pose_.localRotations[find("leftIndexDistal")]), dquat(1, 0, 0, 0)), 1e-5) << "it goes on straight";
    EXPECT_LT(angleBetween(dquat(pose_.localRotations[find("leftMiddleProximal")]), dquat(1, 0, 0, 0)), 1e-5);
}

TEST_F(HandFollowerTest, elbowsHangAndArmsThatAreTooShortPoint) {
    HeadAndHands user = nobody();
    giveHand(user, 0, dquat(1, 0, 0, 0), {0.3, 1.4, 0.3});
    giveHand(user, 1, dquat(1, 0, 0, 0), {-0.3, 1.4, 5});
    pose(user);
    const dvec3 shoulder = placed_.at[find("leftUpperArm")], elbow = placed_.at[find("leftLowerArm")];
    EXPECT_LT(elbow.y, 0.5 * (shoulder.y + 1.4) - 0.05);
    const dvec3 from = placed_.at[find("rightUpperArm")], to = dvec3(user.positions[handJoint(1, kWrist)]);
    const dvec3 arm = placed_.at[find("rightHand")] - from;
    EXPECT_NEAR(glm::length(arm), kReachM, 1e-3);
    EXPECT_LT(glm::distance(glm::normalize(arm), glm::normalize(to - from)), 1e-4);
}

TEST_F(HandFollowerTest, theLowerArmTakesHalfOfTheTwist) {
    for (size_t side = 0; side < 2; ++side) {
        const std::string name = side == 0 ? "left" : "right";
        HeadAndHands user = nobody();
        const dvec3 arm{side == 0 ? 1 : -1, 0, 0};
        giveHand(user, side, glm::angleAxis(1.0, arm), dvec3(kRoot) + dvec3(0, 1.45, 0) + 2.0 * arm);
        pose(user);
        const dquat lower = placed_.world[find(name + "LowerArm")];
        EXPECT_LT(angleBetween(lower, glm::angleAxis(0.5, arm)), 0.03) << "the arm is as good as straight";
        EXPECT_LT(angleBetween(placed_.world[find(name + "Hand")], glm::angleAxis(1.0, arm)), 1e-5);
    }
}

TEST_F(HandFollowerTest, whatIsNotLocatedKeepsTheClip) {
    base_[find("leftIndexIntermediate")] = Quatf(glm::angleAxis(0.4, dvec3(0, 0, 1)));
    base_[find("rightHand")] = Quatf(glm::angleAxis(0.3, dvec3(1, 0, 0)));
    HeadAndHands user = nobody();
    giveHand(user, 0, dquat(1, 0, 0, 0), {0.4, 1.3, 0.2});
    user.tracked[handJoint(0, kIndexIntermediate)] = 0;
    user.rotations[handJoint(0, kIndexIntermediate)].x = std::numeric_limits<float>::quiet_NaN();
    giveHand(user, 1, dquat(1, 0, 0, 0), {-0.4, 1.3, 0.2});
    user.tracked[handJoint(1, kWrist)] = 0;
    pose(user);
    for (size_t j = 0; j < joints_.size(); ++j) {
        const bool left = joints_[j].humanoidBone.starts_with("left");
        EXPECT_EQ(driven_[j] != 0, left && joints_[j].humanoidBone != "leftIndexIntermediate") << joints_[j].humanoidBone;
        if (driven_[j]) continue;
        EXPECT_LT(angleBetween(dquat(pose_.localRotations[j]), dquat(base_[j])), 1e-7) << joints_[j].humanoidBone;
    }
}

TEST_F(HandFollowerTest, theHeadFollowsIfItShall) {
    HeadAndHands user = nobody();
    user.rotations[0] = Quatf(glm::angleAxis(kPi + 0.6, dvec3(0, 1, 0)));  // towards +z and 0.6 to its left
    pose(user);
    EXPECT_FALSE(driven_[find("head")]);
    user.tracked[0] = 1;
    pose(user);
    EXPECT_LT(angleBetween(placed_.world[find("head")], glm::angleAxis(0.6, dvec3(0, 1, 0))), 1e-5);
    EXPECT_LT(angleBetween(placed_.world[find("neck")], glm::angleAxis(0.3, dvec3(0, 1, 0))), 1e-5);
}

TEST_F(HandFollowerTest, anAvatarWithoutBonesIsLeftAlone) {
    const std::vector<JointData> bare = {
        {"a", -1, {0, 0, 0}, ""}, {"b", 0, {0, 1, 0}, "leftHand"}, {"c", 1, {0, 2, 0}, "leftIndexProximal"}};
    HandFollower follower(bare);
    Pose pose = Pose::rest(bare.size());
    std::vector<uint8_t> driven(bare.size(), 0);
    HeadAndHands user = nobody();
    giveHand(user, 0, glm::angleAxis(1.0, dvec3(1, 0, 0)), {1, 1, 1});
    user.tracked[0] = 1;
    follower.pose(user, pose, driven);
    EXPECT_EQ(driven, std::vector<uint8_t>(bare.size(), 0));
}

TEST(PoseFade, neverJumps) {
    constexpr float kStepS = 1 / 90.0f;
    const dquat clip(1, 0, 0, 0), hand = glm::angleAxis(1.5, glm::normalize(dvec3(1, 2, 3)));
    PoseFade fade(1);
    dquat shown = clip;
    double fastest = 0;
    uint32_t driver = 0;
    Pose pose = Pose::rest(1);
    const auto step = [&](bool tracked) {
        if (tracked && driver == 0) driver = 1;
        if (!tracked) driver = 0;
        pose.localRotations[0] = Quatf(tracked ? hand : clip);
        pose.rootTranslation = Vec3f(tracked ? 1.0f : 0.0f, 0, 0);
        const uint32_t drivers[] = {driver, driver};
        fade.step(pose, drivers, kStepS);
        fastest = std::max(fastest, angleBetween(dquat(pose.localRotations[0]), shown));
        shown = dquat(pose.localRotations[0]);
    };
    step(false);
    // Found, lost half-way, found again, lost for good.
    for (const auto& [tracked, frames] : {std::pair{true, 40}, {false, 10}, {true, 5}, {false, 60}})
        for (int i = 0; i < frames; ++i) step(tracked);
    EXPECT_LT(fastest, 1.05 * 1.5 * 1.5 * double(kStepS) / double(kFadeInS)) << "a smooth step is at most 1.5 times as fast as an even one";
    EXPECT_LT(angleBetween(shown, clip), 1e-3);
    EXPECT_LT(std::abs(pose.rootTranslation.x), 1e-4f);
    for (int i = 0; i < 24; ++i) step(true);
    EXPECT_LT(angleBetween(shown, hand), 1e-3) << "it is there after 0.25 s and stays";
    EXPECT_NEAR(pose.rootTranslation.x, 1, 1e-4f);
}

TEST(PoseFade, followsADriverWithoutDelay) {
    PoseFade fade(1);
    for (int i = 0; i < 5; ++i) {
        Pose pose = Pose::rest(1);
        const dquat wanted = glm::angleAxis(0.9 * i, dvec3(0, 1, 0));
        pose.localRotations[0] = Quatf(wanted);
        fade.step(pose, std::vector<uint32_t>{1, 1}, 0.01f);
        EXPECT_LT(angleBetween(dquat(pose.localRotations[0]), wanted), 1e-3);
    }
}

}  // namespace
}  // namespace dpl
