// SPDX-License-Identifier: Apache-2.0
// A user drives an avatar: directions, sides, missing joints, mirrors, and no jumps. The avatar's joints are placed again in double.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <random>

#include "platform/openxr/pose_blend.h"
#include "platform/openxr/puppet.h"

namespace dpl::test {
namespace {

using glm::dquat;
using glm::dvec3;
using xr::Puppet;
using xr::User;

constexpr double kPi = std::numbers::pi, kReachM = 0.53;
constexpr XrQuaternionf kIdentity{0, 0, 0, 1};

dquat wide(const XrQuaternionf& q) {
    return {q.w, q.x, q.y, q.z};
}
dvec3 wide(const XrVector3f& v) {
    return {v.x, v.y, v.z};
}
XrQuaternionf narrow(const dquat& q) {
    return {float(q.x), float(q.y), float(q.z), float(q.w)};
}
XrVector3f narrow(const dvec3& v) {
    return {float(v.x), float(v.y), float(v.z)};
}
/** Between two rotations, radians. */
double angleBetween(const dquat& a, const dquat& b) {
    const dquat d = a * glm::conjugate(b);
    return 2 * std::atan2(glm::length(dvec3(d.x, d.y, d.z)), std::abs(d.w));
}

/** A person in T-pose: palms down, thumbs ahead, 1.7 m. */
std::vector<Puppet::Joint> person() {
    std::vector<Puppet::Joint> joints = {
        {-1, {0, 1, 0}, "hips"}, {0, {0, 1.2f, 0}, "spine"}, {1, {0, 1.5f, 0}, "neck"}, {2, {0, 1.58f, 0}, "head"}};
    const auto add = [&](int parent, XrVector3f at, std::string bone) {
        joints.push_back({parent, at, std::move(bone)});
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

class XrPuppet : public testing::Test {
protected:
    /** Poses the person: `base` is the clip's pose. */
    void pose(const User& user, bool withHead = false) {
        rotations_ = base_;
        puppet_.pose(user, withHead, rotations_, kRoot, driven_);
        placed_ = {};
        for (size_t j = 0; j < joints_.size(); ++j) {
            const int parent = joints_[j].parent;
            const dquat above = parent < 0 ? dquat(1, 0, 0, 0) : placed_.world[size_t(parent)];
            placed_.world.push_back(glm::normalize(above * wide(rotations_[j])));
            placed_.at.push_back(parent < 0
                                     ? wide(joints_[j].rest) + wide(kRoot)
                                     : placed_.at[size_t(parent)] + above * (wide(joints_[j].rest) - wide(joints_[size_t(parent)].rest)));
        }
    }
    size_t find(const std::string& bone) const {
        for (size_t j = 0; j < joints_.size(); ++j)
            if (joints_[j].bone == bone) return j;
        ADD_FAILURE() << bone;
        return 0;
    }
    /** The axes of OpenXR's wrist on the hand at rest, by the picture of a T-pose: -z along the arm, y up. */
    static dquat restHand(int side) { return glm::angleAxis((side == 0 ? -1 : 1) * kPi / 2, dvec3(0, 1, 0)); }
    /** A hand whose joints all have the wrist's rotation. */
    static xr::Hand flatHand(int side, const dquat& turned, const dvec3& wrist) {
        xr::Hand hand;
        hand.located = (1u << XR_HAND_JOINT_COUNT_EXT) - 1;
        for (XrPosef& joint : hand.joints) joint = {narrow(turned * restHand(side)), narrow(wrist)};
        return hand;
    }

    static constexpr XrVector3f kRoot{0.1f, 0.02f, -0.2f};
    std::vector<Puppet::Joint> joints_ = person();
    Puppet puppet_{joints_};
    std::vector<XrQuaternionf> base_ = std::vector<XrQuaternionf>(joints_.size(), kIdentity), rotations_;
    std::vector<uint8_t> driven_ = std::vector<uint8_t>(joints_.size());
    Placed placed_;
};

struct Tracked {
    XrHandJointEXT joint;
    const char *bone, *next;
};
constexpr Tracked kTracked[] = {{XR_HAND_JOINT_THUMB_METACARPAL_EXT, "ThumbMetacarpal", "ThumbProximal"},
                                {XR_HAND_JOINT_THUMB_PROXIMAL_EXT, "ThumbProximal", "ThumbDistal"},
                                {XR_HAND_JOINT_INDEX_PROXIMAL_EXT, "IndexProximal", "IndexIntermediate"},
                                {XR_HAND_JOINT_INDEX_INTERMEDIATE_EXT, "IndexIntermediate", "IndexDistal"},
                                {XR_HAND_JOINT_MIDDLE_PROXIMAL_EXT, "MiddleProximal", "MiddleIntermediate"},
                                {XR_HAND_JOINT_RING_INTERMEDIATE_EXT, "RingIntermediate", "RingDistal"},
                                {XR_HAND_JOINT_LITTLE_PROXIMAL_EXT, "LittleProximal", "LittleIntermediate"}};

TEST_F(XrPuppet, wristsAndFingersAreWhereTheUsersAre) {
    constexpr unsigned kSeed = 5;
    std::mt19937 random(kSeed);
    std::normal_distribution<double> normal(0, 1);
    const auto some = [&](double radians) {
        return glm::angleAxis(radians * normal(random), glm::normalize(dvec3(normal(random), normal(random), normal(random))));
    };
    int within = 0;
    for (int n = 0; n < 50; ++n) {
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", pose " + std::to_string(n));
        for (XrQuaternionf& q : base_) q = narrow(some(0.2));
        User user;
        for (int side = 0; side < 2; ++side) {
            const dvec3 wrist{(side == 0 ? 0.3 : -0.3) + 0.05 * normal(random), 1.4 + 0.05 * normal(random), 0.2 + 0.05 * normal(random)};
            user.hands[side] = flatHand(side, some(0.5), wrist);
            for (int j = XR_HAND_JOINT_THUMB_METACARPAL_EXT; j < XR_HAND_JOINT_COUNT_EXT; ++j) {
                XrQuaternionf& q = user.hands[side].joints[j].orientation;
                q = narrow(wide(q) * some(0.4));
            }
        }
        pose(user);
        for (int side = 0; side < 2; ++side) {
            const std::string name = side == 0 ? "left" : "right";
            const xr::Hand& hand = user.hands[side];
            const size_t wrist = find(name + "Hand");
            const XrPosef& tracked = hand.joints[XR_HAND_JOINT_WRIST_EXT];
            EXPECT_LT(angleBetween(placed_.world[wrist] * restHand(side), wide(tracked.orientation)), 1e-5);
            const double tooFar = glm::distance(placed_.at[find(name + "UpperArm")], wide(tracked.position)) - kReachM;
            EXPECT_NEAR(glm::distance(placed_.at[wrist], wide(tracked.position)), std::max(0.0, tooFar), 1e-4);
            within += tooFar < 0;
            for (const Tracked& finger : kTracked) {
                const dvec3 bone = placed_.at[find(name + finger.next)] - placed_.at[find(name + finger.bone)];
                const dvec3 wanted = wide(hand.joints[finger.joint].orientation) * dvec3(0, 0, -1);
                EXPECT_LT(glm::distance(glm::normalize(bone), wanted), 1e-5) << name << finger.bone;
            }
        }
    }
    EXPECT_GT(within, 50) << "of 100 wrists";
}

TEST_F(XrPuppet, aBentFingerIsBentByThatAngle) {
    User user;
    for (int side = 0; side < 2; ++side) {
        user.hands[side] = flatHand(side, dquat(1, 0, 0, 0), {side == 0 ? 0.7 : -0.7, 1.45, 0});
        // Towards the palm: about the wrist's x axis, down.
        const dquat bent = restHand(side) * glm::angleAxis(-kPi / 3, dvec3(1, 0, 0));
        for (const XrHandJointEXT joint : {XR_HAND_JOINT_INDEX_INTERMEDIATE_EXT, XR_HAND_JOINT_INDEX_DISTAL_EXT})
            user.hands[side].joints[joint].orientation = narrow(bent);
    }
    pose(user);
    const dquat left = glm::angleAxis(-kPi / 3, dvec3(0, 0, 1)), right = glm::angleAxis(kPi / 3, dvec3(0, 0, 1));
    EXPECT_LT(angleBetween(wide(rotations_[find("leftIndexIntermediate")]), left), 1e-5);
    EXPECT_LT(angleBetween(wide(rotations_[find("rightIndexIntermediate")]), right), 1e-5);
    EXPECT_LT(angleBetween(wide(rotations_[find("leftIndexDistal")]), dquat(1, 0, 0, 0)), 1e-5) << "it goes on straight";
    EXPECT_LT(angleBetween(wide(rotations_[find("leftMiddleProximal")]), dquat(1, 0, 0, 0)), 1e-5);
}

TEST_F(XrPuppet, elbowsHangAndArmsThatAreTooShortPoint) {
    User user;
    user.hands[0] = flatHand(0, dquat(1, 0, 0, 0), {0.3, 1.4, 0.3});
    user.hands[1] = flatHand(1, dquat(1, 0, 0, 0), {-0.3, 1.4, 5});
    pose(user);
    const dvec3 shoulder = placed_.at[find("leftUpperArm")], elbow = placed_.at[find("leftLowerArm")];
    EXPECT_LT(elbow.y, 0.5 * (shoulder.y + 1.4) - 0.05);
    const dvec3 from = placed_.at[find("rightUpperArm")], to = wide(user.hands[1].joints[XR_HAND_JOINT_WRIST_EXT].position);
    const dvec3 arm = placed_.at[find("rightHand")] - from;
    EXPECT_NEAR(glm::length(arm), kReachM, 1e-3);
    EXPECT_LT(glm::distance(glm::normalize(arm), glm::normalize(to - from)), 1e-4);
}

TEST_F(XrPuppet, theLowerArmTakesHalfOfTheTwist) {
    for (int side = 0; side < 2; ++side) {
        const std::string name = side == 0 ? "left" : "right";
        User user;
        const dvec3 arm{side == 0 ? 1 : -1, 0, 0};
        user.hands[side] = flatHand(side, glm::angleAxis(1.0, arm), wide(kRoot) + dvec3(0, 1.45, 0) + 2.0 * arm);
        pose(user);
        const dquat lower = placed_.world[find(name + "LowerArm")];
        EXPECT_LT(angleBetween(lower, glm::angleAxis(0.5, arm)), 0.03) << "the arm is as good as straight";
        EXPECT_LT(angleBetween(placed_.world[find(name + "Hand")], glm::angleAxis(1.0, arm)), 1e-5);
    }
}

TEST_F(XrPuppet, whatIsNotLocatedKeepsTheClip) {
    base_[find("leftIndexIntermediate")] = narrow(glm::angleAxis(0.4, dvec3(0, 0, 1)));
    base_[find("rightHand")] = narrow(glm::angleAxis(0.3, dvec3(1, 0, 0)));
    User user;
    user.hands[0] = flatHand(0, dquat(1, 0, 0, 0), {0.4, 1.3, 0.2});
    user.hands[0].located &= ~(1u << XR_HAND_JOINT_INDEX_INTERMEDIATE_EXT);
    user.hands[0].joints[XR_HAND_JOINT_INDEX_INTERMEDIATE_EXT].orientation = {NAN, 0, 0, 0};
    user.hands[1] = flatHand(1, dquat(1, 0, 0, 0), {-0.4, 1.3, 0.2});
    user.hands[1].located &= ~(1u << XR_HAND_JOINT_WRIST_EXT);
    pose(user);
    for (size_t j = 0; j < joints_.size(); ++j) {
        const bool left = joints_[j].bone.starts_with("left");
        EXPECT_EQ(driven_[j] != 0, left && joints_[j].bone != "leftIndexIntermediate") << joints_[j].bone;
        if (driven_[j]) continue;
        EXPECT_EQ(angleBetween(wide(rotations_[j]), wide(base_[j])), 0) << joints_[j].bone;
    }
}

TEST_F(XrPuppet, theHeadFollowsIfItShall) {
    User user;
    user.head.orientation = narrow(glm::angleAxis(kPi + 0.6, dvec3(0, 1, 0)));  // towards +z and 0.6 to its left
    pose(user);
    EXPECT_FALSE(driven_[find("head")]);
    pose(user, true);
    EXPECT_LT(angleBetween(placed_.world[find("head")], glm::angleAxis(0.6, dvec3(0, 1, 0))), 1e-5);
    EXPECT_LT(angleBetween(placed_.world[find("neck")], glm::angleAxis(0.3, dvec3(0, 1, 0))), 1e-5);
}

TEST_F(XrPuppet, anAvatarWithoutBonesIsLeftAlone) {
    const std::vector<Puppet::Joint> bare = {{-1, {0, 0, 0}, ""}, {0, {0, 1, 0}, "leftHand"}, {1, {0, 2, 0}, "leftIndexProximal"}};
    Puppet puppet(bare);
    std::vector<XrQuaternionf> rotations(bare.size(), kIdentity);
    std::vector<uint8_t> driven(bare.size(), 1);
    User user;
    user.hands[0] = flatHand(0, glm::angleAxis(1.0, dvec3(1, 0, 0)), {1, 1, 1});
    puppet.pose(user, true, rotations, {0, 0, 0}, driven);
    EXPECT_EQ(driven, std::vector<uint8_t>(bare.size(), 0));
    Puppet({}).pose(user, true, {}, {0, 0, 0}, {});
}

User someUser() {
    User user;
    user.head = {narrow(glm::normalize(dquat(0.9, 0.1, -0.3, 0.05))), {0.3f, 1.6f, 0.2f}};
    for (int side = 0; side < 2; ++side)
        for (int j = 0; j < XR_HAND_JOINT_COUNT_EXT; ++j) {
            user.hands[side].joints[j] = {narrow(glm::normalize(dquat(0.4 + side, 0.02 * j, 0.5, -0.2))),
                                          {0.2f - side, 1.1f, -0.01f * float(j)}};
            user.hands[side].located = 0x155u << side;
        }
    return user;
}

void expectSame(const XrPosef& a, const XrPosef& b) {
    EXPECT_LT(angleBetween(wide(a.orientation), wide(b.orientation)), 1e-5);
    EXPECT_LT(glm::distance(wide(a.position), wide(b.position)), 1e-5);
}

TEST(XrMirror, twiceIsTheSame) {
    const dvec3 normal = glm::normalize(dvec3(0.3, -0.2, 0.8));
    const xr::Mirror mirror{{0.5f, 1, -2}, narrow(normal)};
    const User user = someUser(), twice = mirrored(mirror, mirrored(mirror, user));
    expectSame(twice.head, user.head);
    for (int side = 0; side < 2; ++side) {
        EXPECT_EQ(twice.hands[side].located, user.hands[side].located);
        EXPECT_EQ(mirrored(mirror, user).hands[side].located, user.hands[1 - side].located) << "left is right";
        for (int j = 0; j < XR_HAND_JOINT_COUNT_EXT; ++j) expectSame(twice.hands[side].joints[j], user.hands[side].joints[j]);
    }
}

TEST(XrMirror, reflectsPointsAndAxes) {
    const dvec3 normal = glm::normalize(dvec3(0.3, -0.2, 0.8)), on{0.5, 1, -2};
    const xr::Mirror mirror{narrow(on), narrow(normal)};
    const XrPosef pose = someUser().head, image = mirrored(mirror, pose);
    const auto reflected = [&](const dvec3& v) { return v - 2 * glm::dot(v, normal) * normal; };
    EXPECT_LT(glm::distance(wide(image.position), on + reflected(wide(pose.position) - on)), 1e-6);
    for (int axis = 0; axis < 3; ++axis) {
        dvec3 unit(0);
        unit[axis] = 1;
        const dvec3 expected = (axis == 0 ? -1.0 : 1.0) * reflected(wide(pose.orientation) * unit);
        EXPECT_LT(glm::distance(wide(image.orientation) * unit, expected), 1e-6) << axis;
    }
}

/** A user before a mirror lifts the left hand: the avatar behind it lifts the hand that is seen on the left, its right one, to the image.
 */
TEST_F(XrPuppet, theLeftHandMovesTheHandThatIsSeenOnTheLeft) {
    const xr::Mirror mirror{{0, 0, -1}, {0, 0, 1}};
    User user;
    user.head.position = {0.1f, 1.6f, 0.3f};
    user.hands[0] = flatHand(0, glm::angleAxis(kPi, dvec3(0, 1, 0)), {-0.2, 1.4, 0.1});  // the user faces -z
    const User image = mirrored(mirror, user);
    xr::Stance stance;
    const XrPosef worldFromAvatar = stance.of(image);
    EXPECT_LT(glm::distance(wide(worldFromAvatar.position), dvec3(0.1, 0, -2.3)), 1e-6);
    EXPECT_LT(angleBetween(wide(worldFromAvatar.orientation), dquat(1, 0, 0, 0)), 1e-6) << "it faces the user";
    pose(moved(xr::inverse(worldFromAvatar), image), true);
    EXPECT_TRUE(driven_[find("rightHand")]);
    EXPECT_FALSE(driven_[find("leftHand")]);
    const dvec3 hand = wide(worldFromAvatar.position) + placed_.at[find("rightHand")];
    EXPECT_LT(glm::distance(hand, dvec3(-0.2, 1.4, -2.1)), 1e-5);
    EXPECT_LT(angleBetween(placed_.world[find("head")], dquat(1, 0, 0, 0)), 1e-6);
}

User lookingTo(double yaw, double pitch = 0) {
    User user;
    user.head.orientation = narrow(glm::angleAxis(yaw, dvec3(0, 1, 0)) * glm::angleAxis(pitch, dvec3(1, 0, 0)));
    return user;
}

TEST(XrStance, turnsOnlyAfterTheHeadHasTurnedFar) {
    constexpr double kDegree = kPi / 180;
    xr::Stance stance;
    const dquat start = wide(stance.of(lookingTo(3)).orientation);
    EXPECT_LT(angleBetween(start, glm::angleAxis(3 + kPi, dvec3(0, 1, 0))), 1e-5);
    EXPECT_LT(angleBetween(wide(stance.of(lookingTo(3 + 45 * kDegree)).orientation), start), 1e-5);
    EXPECT_LT(angleBetween(wide(stance.of(lookingTo(3, -kPi / 2)).orientation), start), 1e-5) << "straight down";
    const dquat turned = wide(stance.of(lookingTo(3 + 90 * kDegree)).orientation);
    EXPECT_LT(angleBetween(turned, glm::angleAxis(40 * kDegree, dvec3(0, 1, 0)) * start), 1e-5);
    EXPECT_LT(angleBetween(wide(stance.of(lookingTo(3)).orientation), turned), 1e-5);
}

TEST(XrPoseBlend, neverJumps) {
    constexpr float kStepS = 1 / 90.0f;
    const dquat clip(1, 0, 0, 0), hand = glm::angleAxis(1.5, glm::normalize(dvec3(1, 2, 3)));
    xr::PoseBlend blend(1);
    dquat shown = clip;
    double fastest = 0;
    const auto step = [&](bool tracked) {
        std::array<XrQuaternionf, 1> q = {narrow(tracked ? hand : clip)};
        const std::array<uint8_t, 1> driven = {uint8_t(tracked)};
        blend.step(q, driven, kStepS);
        fastest = std::max(fastest, angleBetween(wide(q[0]), shown));
        shown = wide(q[0]);
    };
    step(false);
    // Found, lost half-way, found again, lost for good.
    for (const auto& [tracked, frames] : {std::pair{true, 40}, {false, 10}, {true, 5}, {false, 40}})
        for (int i = 0; i < frames; ++i) step(tracked);
    EXPECT_LT(fastest, 1.05 * 1.5 * 1.5 * kStepS / xr::kPoseBlendS) << "a smooth step is at most 1.5 times as fast as an even one";
    EXPECT_LT(angleBetween(shown, clip), 1e-6);
    for (int i = 0; i < 24; ++i) step(true);
    EXPECT_LT(angleBetween(shown, hand), 1e-5) << "it is there after 0.25 s and stays";
}

TEST(XrPoseBlend, followsADriverWithoutDelay) {
    xr::PoseBlend blend(1);
    for (int i = 0; i < 5; ++i) {
        const dquat wanted = glm::angleAxis(0.9 * i, dvec3(0, 1, 0));
        std::array<XrQuaternionf, 1> q = {narrow(wanted)};
        blend.step(q, std::array<uint8_t, 1>{1}, 0.01f);
        EXPECT_LT(angleBetween(wide(q[0]), wanted), 1e-6);
    }
}

}  // namespace
}  // namespace dpl::test
