// SPDX-License-Identifier: Apache-2.0
// A user drives an avatar: sides, mirrors, hands that get lost. The rules joint by joint are tested in tests/unit/avatar.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <optional>

#include "platform/openxr/puppet.h"
#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/avatar/rigs.h"

namespace dpl::test {
namespace {

using glm::dquat;
using glm::dvec3;
using xr::User;

constexpr double kPi = std::numbers::pi;

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

/** An avatar with the humanoid bones of a person, of a CPU context. */
class XrPuppet : public testing::Test {
protected:
    void SetUp() override {
        AvatarData data = tinyAvatar();
        data.joints = personRig(0);
        sortSplats(data);
        const auto bytes = writeAvatar(data);
        ASSERT_TRUE(bytes);
        auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
        ASSERT_TRUE(context);
        context_.emplace(std::move(*context));
        auto avatar = context_->loadAvatar(*bytes);
        ASSERT_TRUE(avatar);
        avatar_.emplace(std::move(*avatar));
        auto puppet = xr::Puppet::of(*avatar_);
        ASSERT_TRUE(puppet) << puppet.error().message;
        puppet_.emplace(std::move(*puppet));
        EXPECT_TRUE(puppet_->drives());
    }
    dvec3 at(const char* bone) const {
        const auto joint = avatar_->findJoint(bone);
        const auto positions = avatar_->jointPositions();
        if (!joint || !positions) return dvec3(NAN);
        return {(*positions)[3 * *joint], (*positions)[3 * *joint + 1], (*positions)[3 * *joint + 2]};
    }
    /** A hand as the rest pose of personRig has it, palm down, moved to `wrist`. */
    static xr::Hand handAt(int side, const dquat& turned, const dvec3& wrist) {
        xr::Hand hand;
        hand.located = (1u << XR_HAND_JOINT_COUNT_EXT) - 1;
        const double s = side == 0 ? 1 : -1;
        for (XrPosef& joint : hand.joints) joint = {narrow(turned * glm::angleAxis(-s * kPi / 2, dvec3(0, 1, 0))), narrow(wrist)};
        const auto put = [&](XrHandJointEXT joint, double z) {
            hand.joints[joint].position = narrow(wrist + turned * dvec3(0.09 * s, 0, z));
        };
        put(XR_HAND_JOINT_INDEX_PROXIMAL_EXT, 0.03), put(XR_HAND_JOINT_MIDDLE_PROXIMAL_EXT, 0.01),
            put(XR_HAND_JOINT_LITTLE_PROXIMAL_EXT, -0.03);
        return hand;
    }
    void settle(const User& user, double seconds = 0.4) {
        std::vector<float> rest(4 * size_t(avatar_->info()->jointCount), 0.0f);
        for (size_t w = 3; w < rest.size(); w += 4) rest[w] = 1;
        for (const double end = timeS_ + seconds; timeS_ < end; timeS_ += 1 / 90.0) {
            ASSERT_TRUE(avatar_->setPose(rest));
            ASSERT_TRUE(puppet_->pose(user, true, timeS_));
        }
    }

    std::optional<doppel::Context> context_;
    std::optional<doppel::Avatar> avatar_;
    std::optional<xr::Puppet> puppet_;
    double timeS_ = 1;
};

/** A user before a mirror lifts the left hand: the avatar behind it lifts the hand that is seen on the left, its right one, to the image.
 */
TEST_F(XrPuppet, theLeftHandMovesTheHandThatIsSeenOnTheLeft) {
    const xr::Mirror mirror{{0, 0, -1}, {0, 0, 1}};
    User user;
    user.head.position = {0.1f, 1.6f, 0.3f};
    user.hands[0] = handAt(0, glm::angleAxis(kPi, dvec3(0, 1, 0)), {-0.2, 1.3, 0.0});  // the user faces -z
    const User image = mirrored(mirror, user);
    xr::Stance stance;
    const XrPosef worldFromAvatar = stance.of(image);
    EXPECT_LT(glm::distance(wide(worldFromAvatar.position), dvec3(0.1, 0, -2.3)), 1e-6);
    EXPECT_LT(angleBetween(wide(worldFromAvatar.orientation), dquat(1, 0, 0, 0)), 1e-6) << "it faces the user";
    const dvec3 leftBefore = at("leftHand");
    settle(moved(xr::inverse(worldFromAvatar), image));
    EXPECT_LT(glm::distance(wide(worldFromAvatar.position) + at("rightHand"), dvec3(-0.2, 1.3, -2.0)), 1e-3);
    EXPECT_LT(glm::distance(at("leftHand"), leftBefore), 1e-4) << "a hand that is not located keeps the pose beneath";
}

TEST_F(XrPuppet, aLostHandGoesBackWithoutAJump) {
    const dvec3 rest = at("leftHand");
    User user;
    user.hands[0] = handAt(0, dquat(1, 0, 0, 0), {0.3, 1.35, 0.25});
    settle(user);
    EXPECT_LT(glm::distance(at("leftHand"), dvec3(0.3, 1.35, 0.25)), 1e-3);
    double fastest = 0;
    dvec3 before = at("leftHand");
    user.hands[0].located = 0;
    for (int i = 0; i < 100; ++i) {
        settle(user, 0.5 / 90);
        fastest = std::max(fastest, glm::distance(at("leftHand"), before));
        before = at("leftHand");
    }
    EXPECT_LT(glm::distance(before, rest), 1e-3) << "0.3 s later it has begun to fade, 0.8 s later it is there";
    EXPECT_LT(fastest, 0.02) << "metres from picture to picture at 90 Hz: 0.43 m in half a second, smoothly";
}

TEST(XrPuppetOf, avatarsWithoutBonesAreNotDriven) {
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    ASSERT_TRUE(context);
    AvatarData data = tinyAvatar();
    sortSplats(data);
    const auto avatar = context->loadAvatar(*writeAvatar(data));
    ASSERT_TRUE(avatar);
    auto puppet = xr::Puppet::of(*avatar);
    ASSERT_TRUE(puppet);
    EXPECT_FALSE(puppet->drives());
    EXPECT_TRUE(puppet->pose(User{}, true, 1));
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

}  // namespace
}  // namespace dpl::test
