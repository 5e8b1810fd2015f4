// SPDX-License-Identifier: Apache-2.0
// The body by XR_FB_body_tracking: from the runtime to the pose of an avatar, and what happens without it.
#include <cmath>
#include <numbers>

#include "platform/openxr/puppet.h"
#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/motion/track_streams.h"
#include "tests/xr/xr_fixture.h"

namespace dpl::test {
namespace {

constexpr XrSpaceLocationFlags kPoseValid = XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
constexpr XrVector3f kStandingHead{0, 1.6f, 0};

XrPosef poseAt(const std::vector<float>& rotations, const std::vector<float>& positions, size_t j) {
    const float *q = &rotations[4 * j], *p = &positions[3 * j];
    return {{q[0], q[1], q[2], q[3]}, {p[0], p[1], p[2]}};
}

/** A person on the mock whose body is a stream of the tests, and an avatar with the same bones. */
class XrBody : public XrTest {
protected:
    void SetUp() override {
        XrTest::SetUp();
        if (IsSkipped() || HasFatalFailure()) return;
        AvatarData data = tinyAvatar();
        data.joints = rig_;
        sortSplats(data);
        auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
        ASSERT_TRUE(context);
        software_.emplace(std::move(*context));
        auto loaded = software_->loadAvatar(*writeAvatar(data));
        ASSERT_TRUE(loaded);
        person_.emplace(std::move(*loaded));
        auto puppet = xr::Puppet::of(*person_);
        ASSERT_TRUE(puppet);
        puppet_.emplace(std::move(*puppet));
    }
    void TearDown() override {
        puppet_.reset(), person_.reset(), software_.reset();
        XrTest::TearDown();
    }

    void tellSkeleton(mockxr::Settings& settings) const {
        settings.skeleton.clear();
        for (size_t j = XR_BODY_JOINT_COUNT_FB; j-- > 0;)  // the order is the runtime's own
            settings.skeleton.push_back({int32_t(j), -1, poseAt(stream_.restRotations, stream_.restPositions, j)});
        ++settings.skeletonChanges;
    }
    void tellBody(mockxr::Settings& settings) const {
        settings.body.clear();
        for (size_t j = 0; j < XR_BODY_JOINT_COUNT_FB; ++j)
            settings.body.push_back({stream_.confidence[j] > 0 ? kPoseValid : 0, poseAt(stream_.rotations, stream_.positions, j)});
    }
    mockxr::Settings tracked() {
        mockxr::Settings settings = userAt(kStandingHead);
        stream_.show(moved_);
        tellSkeleton(settings), tellBody(settings);
        return settings;
    }
    /** A second of frames, each of which poses the person. */
    void follow(int frames = 72) {
        using xr::operator*;
        std::vector<float> rest(4 * rig_.size(), 0.0f);
        for (size_t w = 3; w < rest.size(); w += 4) rest[w] = 1;
        for (int i = 0; i < frames; ++i) {
            ASSERT_EQ(step(), xr::Step::Drew);
            const xr::Frame& frame = session_->lastFrame();
            ASSERT_TRUE(person_->setPose(rest));
            const auto posed = puppet_->pose(xr::moved(xr::inverse(stance_.of(frame.user)), frame.user), false, frame.timeS);
            ASSERT_TRUE(posed) << posed.error().message;
        }
    }
    /** Largest angle between the person's joints and the performer's, of those above the legs, degrees. */
    double offDeg(const Pose& wanted) const {
        std::vector<float> pose(4 * rig_.size());
        if (dplGetPose(person_->handle(), pose.data(), uint32_t(rig_.size()), nullptr) != DPL_OK) return NAN;
        double worst = 0;
        for (size_t j = 0; j < rig_.size(); ++j) {
            const std::string& bone = rig_[j].humanoidBone;
            if (bone.empty() || bone.find("Leg") != bone.npos || bone.find("Foot") != bone.npos || bone.find("Toe") != bone.npos) continue;
            const float* q = &pose[4 * j];
            const Quatf d = glm::inverse(wanted.localRotations[j]) * Quatf(q[3], q[0], q[1], q[2]);
            worst = std::max(worst, 2 * std::atan2(double(glm::length(Vec3f(d.x, d.y, d.z))), std::abs(double(d.w))));
        }
        return worst * 180 / std::numbers::pi;
    }

    std::vector<JointData> rig_ = personRig(0);
    Pose moved_ = swing(rig_, 0.3);
    Stream stream_{TrackFormat::FbBody, rig_, 1, {}, std::numbers::pi_v<float>};  // the user looks along -z
    std::optional<doppel::Context> software_;
    std::optional<doppel::Avatar> person_;
    std::optional<xr::Puppet> puppet_;
    xr::Stance stance_;
};

TEST_F(XrBody, itsPoseReachesTheAvatar) {
    open(tracked(), opaque());
    if (HasFatalFailure()) return;
    ASSERT_TRUE(run(xr::Step::Drew));
    EXPECT_EQ(session_->lastFrame().user.body.skeleton, 1u);
    EXPECT_GT(session_->lastFrame().user.body.located.count(), 40u);
    follow();
    EXPECT_GT(offDeg(Pose::rest(rig_.size())), 20) << "the performer's arms hang and swing";
    EXPECT_LT(offDeg(moved_), 0.1);
    moved_ = swing(rig_, 0.8);
    stream_.show(moved_);
    tellBody(mockxr::settings());
    tellSkeleton(mockxr::settings());
    follow();
    EXPECT_EQ(session_->lastFrame().user.body.skeleton, 2u) << "a skeleton that changes is read again";
    EXPECT_LT(offDeg(moved_), 0.1);
}

TEST_F(XrBody, aBodyThatIsLostGoesBackToThePoseBeneath) {
    open(tracked(), opaque());
    if (HasFatalFailure()) return;
    ASSERT_TRUE(run(xr::Step::Drew));
    follow();
    EXPECT_LT(offDeg(moved_), 0.1);
    mockxr::settings().body.clear();
    follow();
    EXPECT_EQ(session_->lastFrame().user.body.located.count(), 0u);
    EXPECT_LT(offDeg(Pose::rest(rig_.size())), 0.1);
}

TEST_F(XrBody, withoutTheExtensionNothingIsCalled) {
    mockxr::Settings settings = tracked();
    std::erase(settings.extensions, XR_FB_BODY_TRACKING_EXTENSION_NAME);
    open(settings, opaque());
    if (HasFatalFailure()) return;
    ASSERT_TRUE(run(xr::Step::Drew));
    follow(30);
    EXPECT_EQ(mockxr::calls()["xrCreateBodyTrackerFB"], 0u);
    EXPECT_LT(offDeg(Pose::rest(rig_.size())), 0.1) << "hands and clip go on as before";
    EXPECT_EQ(session_->lastComplaint(), "");
}

TEST_F(XrBody, aHeadsetThatTracksNoneIsNotAsked) {
    mockxr::Settings settings = tracked();
    settings.tracksBodies = false;
    open(settings, opaque());
    if (HasFatalFailure()) return;
    ASSERT_TRUE(run(xr::Step::Drew));
    EXPECT_EQ(mockxr::calls()["xrCreateBodyTrackerFB"], 0u);
    EXPECT_EQ(session_->lastComplaint(), "");
}

TEST_F(XrBody, wrongAnswersLeaveTheAvatarAlone) {
    mockxr::Settings settings = tracked();
    settings.skeleton[5].joint = 99;
    open(settings, opaque());
    if (HasFatalFailure()) return;
    ASSERT_TRUE(run(xr::Step::Drew));
    follow(10);
    EXPECT_EQ(session_->lastFrame().user.body.skeleton, 0u);
    EXPECT_EQ(session_->lastComplaint(), "the runtime does not tell where the body is");
    EXPECT_LT(offDeg(Pose::rest(rig_.size())), 0.1);
    tellSkeleton(mockxr::settings());
    for (XrBodyJointLocationFB& joint : mockxr::settings().body) joint.pose.position.y = NAN;
    follow(10);
    EXPECT_EQ(session_->lastFrame().user.body.located.count(), 0u);
    tellBody(mockxr::settings());
    for (XrBodyJointLocationFB& joint : mockxr::settings().body) joint.pose.position.x = -joint.pose.position.x;
    follow(10);  // left and right swapped: dropped
    EXPECT_LT(offDeg(Pose::rest(rig_.size())), 0.1);
    tellBody(mockxr::settings());
    follow();
    EXPECT_LT(offDeg(moved_), 0.1);
    mockxr::fail({"xrLocateBodyJointsFB", mockxr::calls()["xrLocateBodyJointsFB"] + 1, 1, XR_ERROR_RUNTIME_FAILURE});
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_EQ(session_->lastFrame().user.body.located.count(), 0u);
}

/** A rest pose that is no person, such as one with all joints at the origin, is not followed, and hands go on. */
TEST_F(XrBody, aSkeletonThatIsNoPersonIsNotFollowed) {
    mockxr::Settings settings = tracked();
    for (XrBodySkeletonJointFB& joint : settings.skeleton) joint.pose.position = {0, 0, 0};
    open(settings, opaque());
    if (HasFatalFailure()) return;
    ASSERT_TRUE(run(xr::Step::Drew));
    follow(30);
    EXPECT_LT(offDeg(Pose::rest(rig_.size())), 0.1);
    tellSkeleton(mockxr::settings());
    follow();
    EXPECT_LT(offDeg(moved_), 0.1) << "until the runtime tells a better one";
}

TEST_F(XrBody, drawingGoesOnWithoutATracker) {
    open(tracked(), opaque());
    if (HasFatalFailure()) return;
    mockxr::fail({"xrCreateBodyTrackerFB", 1, 1, XR_ERROR_RUNTIME_FAILURE});
    ASSERT_TRUE(run(xr::Step::Drew));
    EXPECT_EQ(session_->lastComplaint().substr(0, 9), "no body: ");
    EXPECT_EQ(session_->lastFrame().user.body.located.count(), 0u);
}

}  // namespace
}  // namespace dpl::test
