// SPDX-License-Identifier: Apache-2.0
// Hands by XR_EXT_hand_tracking: located in the world, and only as far as the runtime tells something that can be true.
#include <cmath>

#include "tests/xr/xr_fixture.h"

namespace dpl::test {
namespace {

constexpr XrVector3f kHead{0, 1, 2.9f};
constexpr uint32_t kAll = (1u << XR_HAND_JOINT_COUNT_EXT) - 1;
constexpr XrSpaceLocationFlags kValid = XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;

/** Joints in a row along x, turned about y. */
std::vector<XrHandJointLocationEXT> row(float x) {
    std::vector<XrHandJointLocationEXT> joints(XR_HAND_JOINT_COUNT_EXT);
    for (size_t j = 0; j < joints.size(); ++j) joints[j] = {kValid, {{0, 0.6f, 0, 0.8f}, {x + 0.01f * float(j), 1.2f, 2.5f}}, 0.01f};
    return joints;
}

class XrHands : public XrTest {
protected:
    void draw(const mockxr::Settings& settings) {
        open(settings, opaque());
        if (!HasFatalFailure()) {
            ASSERT_TRUE(run(xr::Step::Drew));
        }
    }
    const xr::Hand& hand(int side) const { return session_->lastFrame().user.hands[side]; }
};

TEST_F(XrHands, areWhereTheRuntimeSeesThem) {
    mockxr::Settings settings = userAt(kHead);
    settings.hands[0].joints = row(-0.4f), settings.hands[1].joints = row(0.1f);
    draw(settings);
    for (int side = 0; side < 2; ++side) {
        ASSERT_EQ(hand(side).located, kAll);
        for (uint32_t j = 0; j < XR_HAND_JOINT_COUNT_EXT; ++j) {
            EXPECT_NEAR(hand(side).joints[j].position.x, (side == 0 ? -0.4f : 0.1f) + 0.01f * float(j), 1e-6f);
            EXPECT_NEAR(hand(side).joints[j].position.y, 1.2f, 1e-6f) << "from the floor";
            EXPECT_NEAR(hand(side).joints[j].orientation.y, 0.6f, 1e-6f);
        }
    }
    const XrVector3f head = session_->lastFrame().user.head.position;
    EXPECT_NEAR(head.x, kHead.x, 1e-6f) << "between the eyes";
    EXPECT_NEAR(head.z, kHead.z, 1e-6f);
}

TEST_F(XrHands, comeAndGo) {
    draw(userAt(kHead));
    EXPECT_EQ(hand(0).located, 0u);
    mockxr::settings().hands[0].joints = row(0);
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_EQ(hand(0).located, kAll);
    EXPECT_EQ(hand(1).located, 0u);
    mockxr::settings().hands[0].joints.clear();
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_EQ(hand(0).located, 0u);
}

TEST_F(XrHands, jointsThatCannotBeAreNotLocated) {
    mockxr::Settings settings = userAt(kHead);
    auto& joints = settings.hands[1].joints = row(0);
    joints[0].locationFlags = 0;
    joints[1].locationFlags = XR_SPACE_LOCATION_POSITION_VALID_BIT;
    joints[2].locationFlags = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    joints[3].pose.orientation = {0, 0, 0, 0};
    joints[4].pose.orientation.x = NAN;
    joints[5].pose.orientation.w = 3;
    joints[6].pose.position.y = NAN;
    joints[7].pose.position.z = INFINITY;
    joints[8].pose.position.x = 1e30f;
    draw(settings);
    EXPECT_EQ(hand(1).located, kAll & ~0x1FFu);
}

TEST_F(XrHands, withoutTheExtensionNothingIsCalled) {
    mockxr::Settings settings = userAt(kHead);
    std::erase(settings.extensions, XR_EXT_HAND_TRACKING_EXTENSION_NAME);
    settings.hands[0].joints = row(0);
    draw(settings);
    EXPECT_EQ(hand(0).located, 0u);
    EXPECT_EQ(mockxr::calls()["xrCreateHandTrackerEXT"], 0u);
}

TEST_F(XrHands, aHeadsetThatTracksNoneIsNotAsked) {
    mockxr::Settings settings = userAt(kHead);
    settings.tracksHands = false;
    draw(settings);
    EXPECT_EQ(mockxr::calls()["xrCreateHandTrackerEXT"], 0u);
    EXPECT_EQ(session_->lastComplaint(), "");
}

TEST_F(XrHands, drawingGoesOnWithoutThem) {
    mockxr::Settings settings = userAt(kHead);
    settings.hands[0].joints = settings.hands[1].joints = row(0);
    open(settings, opaque());
    if (HasFatalFailure()) return;
    mockxr::fail({"xrCreateHandTrackerEXT", 2, 1, XR_ERROR_RUNTIME_FAILURE});
    ASSERT_TRUE(run(xr::Step::Drew));
    EXPECT_EQ(session_->lastComplaint().substr(0, 10), "no hands: ");
    EXPECT_EQ(hand(0).located, 0u) << "both or none";
    closeSession();
    openSession(opaque());
    ASSERT_TRUE(run(xr::Step::Drew));
    EXPECT_EQ(hand(0).located, kAll);
    mockxr::fail({"xrLocateHandJointsEXT", mockxr::calls()["xrLocateHandJointsEXT"] + 1, 1, XR_ERROR_RUNTIME_FAILURE});
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_EQ(hand(0).located, 0u);
    EXPECT_EQ(session_->lastComplaint(), "the runtime does not tell where the hands are");
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_EQ(hand(0).located, kAll);
}

}  // namespace
}  // namespace dpl::test
