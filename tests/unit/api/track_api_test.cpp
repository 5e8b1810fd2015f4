// SPDX-License-Identifier: Apache-2.0
// Trackers through the C API: arguments, ownership, the pose beneath, and frames from another thread.
#include <atomic>
#include <thread>

#include "sdk/include/doppel/doppel.hpp"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/motion/track_streams.h"

namespace dpl {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

class ApiTrack : public test::ApiTest {
protected:
    void SetUp() override {
        test::ApiTest::SetUp();
        AvatarData person = test::tinyAvatar();
        person.joints = test::personRig(0.8f);
        person.clips.clear();
        person.correctives = {};
        sortSplats(person);
        const auto bytes = writeAvatar(person);
        ASSERT_TRUE(bytes) << bytes.error().message;
        ASSERT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &person_), DPL_OK) << dplGetLastError();
        info_.structSize = sizeof info_;
        info_.format = DPL_TRACK_VRM;
    }
    void TearDown() override {
        EXPECT_EQ(dplDestroyAvatar(person_), DPL_OK);
        test::ApiTest::TearDown();
    }
    DplTrackFrame frameOf(const test::Stream& stream, int64_t timeNs) const {
        DplTrackFrame frame{};
        frame.structSize = sizeof frame, frame.timeNs = timeNs, frame.jointCount = uint32_t(stream.confidence.size());
        frame.rotations = stream.rotations.data(), frame.positions = stream.positions.data(), frame.confidence = stream.confidence.data();
        return frame;
    }

    DplAvatar person_ = nullptr;
    DplTrackerInfo info_{};
};

TEST_F(ApiTrack, namesAndCountsOfJointsAreThePlatforms) {
    const auto last = [](DplTrackFormat format, uint32_t joint) {
        const char *name = nullptr, *behind = "untouched";
        EXPECT_EQ(dplGetTrackJointName(format, joint, &name), DPL_OK);
        EXPECT_EQ(dplGetTrackJointName(format, joint + 1, &behind), DPL_ERROR_NOT_FOUND);
        EXPECT_STREQ(behind, "untouched");
        return std::string(name);
    };
    EXPECT_EQ(last(DPL_TRACK_VRM, 54), "rightLittleDistal");
    EXPECT_EQ(last(DPL_TRACK_UNITY, 54), "UpperChest");
    EXPECT_EQ(last(DPL_TRACK_ARKIT_BODY, 90), "right_handThumbEnd_joint");
    EXPECT_EQ(last(DPL_TRACK_FB_BODY, 69), "RIGHT_HAND_LITTLE_TIP");
    EXPECT_EQ(last(DPL_TRACK_OPENXR_HANDS, 52), "RIGHT_LITTLE_TIP");
    EXPECT_EQ(last(DPL_TRACK_MEDIAPIPE_POSE, 32), "right foot index");
    const auto at = [](DplTrackFormat format, uint32_t joint) { return std::string(*doppel::trackJointName(format, joint)); };
    EXPECT_EQ(at(DPL_TRACK_ARKIT_BODY, 47), "neck_1_joint");
    EXPECT_EQ(at(DPL_TRACK_ARKIT_BODY, 66), "right_hand_joint");
    EXPECT_EQ(at(DPL_TRACK_FB_BODY, 20), "LEFT_HAND_THUMB_METACARPAL");
    EXPECT_EQ(at(DPL_TRACK_FB_BODY, 45), "RIGHT_HAND_WRIST");
    EXPECT_EQ(at(DPL_TRACK_UNITY, 24), "LeftThumbProximal");
    EXPECT_EQ(at(DPL_TRACK_MEDIAPIPE_POSE, 23), "left hip");
    EXPECT_FALSE(doppel::trackJointName(DplTrackFormat(6), 0));
}

TEST_F(ApiTrack, wrongCallsAreRefusedWithASentence) {
    DplTracker tracker = nullptr;
    const auto refused = [&](const char* says) {
        EXPECT_EQ(dplCreateTracker(person_, &info_, &tracker), DPL_ERROR_INVALID_ARGUMENT);
        EXPECT_TRUE(errorSays(says)) << dplGetLastError();
        EXPECT_EQ(tracker, nullptr);
        info_ = {};
        info_.structSize = sizeof info_;
    };
    info_.flags = 16, refused("flags");
    info_.format = DPL_TRACK_ARKIT_BODY, refused("91 joints");
    info_.restCount = 3, refused("restCount");
    info_.restCount = 55, refused("NULL");
    info_.structSize = 8, refused("structSize");
    EXPECT_EQ(dplCreateTracker(person_, nullptr, &tracker), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplCreateTracker(person_, &info_, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplCreateTracker(nullptr, &info_, &tracker), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplCreateTracker(avatar_, &info_, &tracker), DPL_ERROR_UNSUPPORTED) << "the tiny avatar has no humanoid";
    ASSERT_EQ(dplCreateTracker(person_, &info_, &tracker), DPL_OK) << dplGetLastError();
    test::Stream stream(TrackFormat::Vrm, test::personRig(0), 1);
    DplTrackFrame frame = frameOf(stream, 1);
    frame.jointCount = 54;
    EXPECT_EQ(dplTrackFrame(tracker, &frame), DPL_ERROR_INVALID_ARGUMENT);
    frame = frameOf(stream, 1), frame.rotations = nullptr;
    EXPECT_EQ(dplTrackFrame(tracker, &frame), DPL_ERROR_INVALID_ARGUMENT);
    frame = frameOf(stream, 1), frame.positions = nullptr;
    EXPECT_EQ(dplTrackFrame(tracker, &frame), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplTrackFrame(tracker, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplTrackFrame(nullptr, &frame), DPL_ERROR_INVALID_ARGUMENT);
    frame = frameOf(stream, 1);
    for (float& p : stream.positions) p = -p;
    log_.clear();
    EXPECT_EQ(dplTrackFrame(tracker, &frame), DPL_ERROR_CORRUPT_DATA) << "sides swapped";
    EXPECT_TRUE(log_.empty()) << "what a stream does is not logged: " << log_;
    EXPECT_EQ(dplDestroyTracker(tracker), DPL_OK);
    EXPECT_EQ(dplDestroyTracker(tracker), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyTracker(nullptr), DPL_OK);
    EXPECT_EQ(dplSetPoseFromTracker(tracker, 0, nullptr), DPL_ERROR_INVALID_ARGUMENT);
}

TEST_F(ApiTrack, aTrackerPosesItsAvatarOverTheRestPoseOrTheCurrentOne) {
    const uint32_t joints = uint32_t(test::personRig(0).size());
    uint32_t finger = 0, elbow = 0;
    ASSERT_EQ(dplFindJoint(person_, "leftIndexDistal", &finger), DPL_OK);
    ASSERT_EQ(dplFindJoint(person_, "leftLowerArm", &elbow), DPL_OK);
    std::vector<float> pose(4 * joints);
    for (uint32_t j = 0; j < joints; ++j) pose[4 * j + 3] = 1;
    pose[4 * finger + 1] = 0.6f, pose[4 * finger + 3] = 0.8f;
    test::Stream stream(TrackFormat::Vrm, test::personRig(0), 1);
    for (const uint32_t flags : {0u, uint32_t(DPL_TRACKER_OVER_POSE)}) {
        info_.flags = flags | DPL_TRACKER_RAW;
        DplTracker tracker = nullptr;
        ASSERT_EQ(dplCreateTracker(person_, &info_, &tracker), DPL_OK) << dplGetLastError();
        DplTrackerStatus status{};
        status.structSize = sizeof status;
        ASSERT_EQ(dplSetPose(person_, pose.data(), joints, nullptr), DPL_OK);
        EXPECT_EQ(dplSetPoseFromTracker(tracker, kSecond, &status), DPL_OK);
        EXPECT_EQ(status.state, DPL_TRACKER_WAITING);
        EXPECT_EQ(status.drivenJoints, 0u);
        stream.show(test::swing(test::personRig(0), 0.3));
        stream.confidence[size_t(std::find_if(trackedJoints(TrackFormat::Vrm).begin(), trackedJoints(TrackFormat::Vrm).end(),
                                              [](const TrackedJoint& j) { return j.bone == "leftIndexDistal"; }) -
                                 trackedJoints(TrackFormat::Vrm).begin())] = 0;
        const DplTrackFrame frame = frameOf(stream, 2 * kSecond);
        ASSERT_EQ(dplTrackFrame(tracker, &frame), DPL_OK) << dplGetLastError();
        std::vector<float> shown(4 * joints);
        for (int k = 0; k < 10; ++k) {  // past the fade
            ASSERT_EQ(dplSetPose(person_, pose.data(), joints, nullptr), DPL_OK);
            ASSERT_EQ(dplSetPoseFromTracker(tracker, 2 * kSecond + k * kSecond / 30, &status), DPL_OK);
        }
        EXPECT_EQ(status.state, DPL_TRACKER_TRACKING);
        EXPECT_EQ(status.framesTaken, 1u);
        EXPECT_GT(status.drivenJoints, 30u);
        ASSERT_EQ(dplGetPose(person_, shown.data(), joints, nullptr), DPL_OK);
        EXPECT_NEAR(shown[4 * finger + 1], flags ? 0.6f : 0.0f, 1e-5f) << "a joint without data shows the pose beneath";
        EXPECT_LT(shown[4 * elbow + 3], 0.99f) << "a tracked elbow is bent";
        EXPECT_EQ(dplDestroyTracker(tracker), DPL_OK);
    }
}

/** A headset: the hands are tracked, the legs play a clip. Clothes remember by the tracker's stamps, whatever time the clip has. */
TEST_F(ApiTrack, clothesRememberByTheTrackersStampsAndNotByTheClipBeneath) {
    AvatarData data = test::tinyAvatar();
    data.joints = test::personRig(0.8f);
    ClipData step;
    step.name = "step", step.timesS = {0, 1};
    step.channels = {{uint32_t(test::jointOf(data.joints, "leftUpperLeg")), {Quatf(1, 0, 0, 0), glm::angleAxis(1.2f, Vec3f(1, 0, 0))}}};
    data.clips = {step};
    sortSplats(data);
    data = test::withCorrectives(std::move(data), 3, {.offsetM = 0.2f, .reach = 0.01f, .motion = 4});
    MotionModeData& motion = data.correctives.motion;
    motion.movedFromRad = 0.01f, motion.movedToRad = 0.02f, motion.holdsS = {0, 2};
    motion.still.assign(motion.joints.size(), Vec4f(0, 0, 0, 1)), motion.rangeRad.assign(motion.joints.size(), Vec2f(0.01f, 2));
    const auto bytes = writeAvatar(data);
    ASSERT_TRUE(bytes) << bytes.error().message;
    DplAvatar dressed = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &dressed), DPL_OK) << dplGetLastError();
    info_.format = DPL_TRACK_OPENXR_HANDS, info_.flags = DPL_TRACKER_OVER_POSE | DPL_TRACKER_RAW;
    const DplCamera camera = test::frontCamera();
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera, pixels);
    const uint32_t joints = uint32_t(data.joints.size());
    std::vector<std::vector<float>> poses;
    const auto drawn = [&] {
        EXPECT_EQ(dplRender(context_, dressed, &camera, 1, &image), DPL_OK) << dplGetLastError();
        return pixels;
    };
    const auto tracked = [&](int64_t spacingNs) {
        poses.clear();
        DplTracker tracker = nullptr;
        EXPECT_EQ(dplCreateTracker(dressed, &info_, &tracker), DPL_OK) << dplGetLastError();
        EXPECT_EQ(dplSettle(dressed), DPL_OK);
        test::Stream stream(TrackFormat::OpenxrHands, data.joints, 1);
        for (int k = 0; k < 6; ++k) {
            const int64_t timeNs = 100 * kSecond + k * spacingNs;
            stream.show(test::swing(data.joints, 0.1 * k));
            const DplTrackFrame frame = frameOf(stream, timeNs);
            EXPECT_EQ(dplTrackFrame(tracker, &frame), DPL_OK) << dplGetLastError();
            EXPECT_EQ(dplSetPoseFromClip(dressed, 0, k < 4 ? 0.3 * k : 0, DPL_FALSE), DPL_OK) << dplGetLastError();
            EXPECT_EQ(dplSetPoseFromTracker(tracker, timeNs, nullptr), DPL_OK) << dplGetLastError();
            poses.emplace_back(4 * joints + 3);
            EXPECT_EQ(dplGetPose(dressed, poses.back().data(), joints, poses.back().data() + 4 * joints), DPL_OK);
            drawn();
        }
        EXPECT_EQ(dplDestroyTracker(tracker), DPL_OK);
        return pixels;
    };
    const auto farthest = [](const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
        int most = 0;
        for (size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(int(a[i]) - int(b[i])));
        return most;
    };
    for (const int64_t spacingNs : {kSecond / 10, kSecond / 2}) {
        const std::vector<uint8_t> shown = tracked(spacingNs);
        ASSERT_EQ(dplSettle(dressed), DPL_OK);
        for (size_t k = 0; k < poses.size(); ++k) {
            const float* root = poses[k].data() + 4 * joints;
            ASSERT_EQ(dplSetPoseAtTime(dressed, poses[k].data(), joints, root, 100 * kSecond + int64_t(k) * spacingNs), DPL_OK);
            drawn();
        }
        EXPECT_LE(farthest(shown, pixels), 1) << "as the same poses with the same stamps; normalising again may round";
        ASSERT_EQ(dplSetPose(dressed, poses.back().data(), joints, poses.back().data() + 4 * joints), DPL_OK);
        EXPECT_GT(farthest(shown, drawn()), 5) << "there is something to remember";
    }
    EXPECT_GT(farthest(tracked(kSecond / 10), tracked(kSecond / 2)), 5) << "other stamps, other clothes";
    EXPECT_EQ(dplDestroyAvatar(dressed), DPL_OK);
}

TEST_F(ApiTrack, theAvatarMayGoFirst) {
    DplTracker tracker = nullptr;
    ASSERT_EQ(dplCreateTracker(person_, &info_, &tracker), DPL_OK) << dplGetLastError();
    ASSERT_EQ(dplDestroyAvatar(person_), DPL_OK);
    person_ = nullptr;
    test::Stream stream(TrackFormat::Vrm, test::personRig(0), 1);
    const DplTrackFrame frame = frameOf(stream, 1);
    EXPECT_EQ(dplTrackFrame(tracker, &frame), DPL_OK);
    EXPECT_EQ(dplSetPoseFromTracker(tracker, 1, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyTracker(tracker), DPL_OK);
}

TEST_F(ApiTrack, framesComeFromAnotherThreadWhileTheAvatarIsDrawn) {
    DplTracker tracker = nullptr;
    ASSERT_EQ(dplCreateTracker(person_, &info_, &tracker), DPL_OK) << dplGetLastError();
    std::atomic<bool> done{false};
    std::atomic<int> given{0};
    std::thread camera([&] {
        const auto rig = test::personRig(0);
        test::Stream stream(TrackFormat::Vrm, rig, 1);
        for (int k = 0; !done || k < 20; ++k) {
            stream.show(test::swing(rig, k / 60.0));
            const DplTrackFrame frame = frameOf(stream, kSecond + k * kSecond / 60);
            EXPECT_EQ(dplTrackFrame(tracker, &frame), DPL_OK) << dplGetLastError();
            ++given;
        }
    });
    const DplCamera camera3 = test::frontCamera(32, 32);
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera3, pixels);
    for (int k = 0; k < 30; ++k) {
        DplTrackerStatus status{};
        status.structSize = sizeof status;
        ASSERT_EQ(dplSetPoseFromTracker(tracker, kSecond + k * kSecond / 60, &status), DPL_OK) << dplGetLastError();
        ASSERT_EQ(dplRender(context_, person_, &camera3, 1, &image), DPL_OK) << dplGetLastError();
    }
    done = true;
    camera.join();
    EXPECT_GE(given, 20);
    EXPECT_EQ(dplDestroyTracker(tracker), DPL_OK);
}

TEST_F(ApiTrack, theWrapperOwnsAndForwards) {
    doppel::Avatar avatar(context_, std::exchange(person_, nullptr));
    auto tracker = avatar.createTracker(DPL_TRACK_MEDIAPIPE_POSE);
    ASSERT_TRUE(tracker) << tracker.error().message;
    test::Stream stream(TrackFormat::MediapipePose, test::personRig(0), 1);
    stream.show(test::swing(test::personRig(0), 0.2));
    EXPECT_TRUE(tracker->frame(kSecond, {}, stream.positions, stream.confidence));
    EXPECT_FALSE(tracker->frame(2 * kSecond, {}, std::span(stream.positions).first(98)));
    const auto status = tracker->setPose(kSecond);
    ASSERT_TRUE(status) << status.error().message;
    EXPECT_EQ(status->framesTaken, 1u);
    doppel::Tracker moved = std::move(*tracker);
    EXPECT_TRUE(moved.setPose(kSecond + 1));
    EXPECT_FALSE(avatar.createTracker(DPL_TRACK_ARKIT_BODY));
}

}  // namespace
}  // namespace dpl
