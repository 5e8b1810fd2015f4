// SPDX-License-Identifier: Apache-2.0
// Which frames of a video are chosen, and where a video is split, from made motion and from made pictures.
#include "reconstruction/input/import/frame_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dpl {
namespace {

std::vector<FrameMotion> steady(size_t count, double camera, double pose) {
    std::vector<FrameMotion> frames(count);
    for (size_t i = 0; i < count; ++i) frames[i] = {double(i) / 12, 100, camera, pose, true, 0.1};
    return frames;
}

TEST(ChooseFrames, followTheCameraNotTheClock) {
    auto frames = steady(200, 0.01, 0);
    for (size_t i = 100; i < 200; ++i) frames[i].cameraMotion = 0;  // the camera rests for the second half
    const auto chosen = chooseFrames(frames, {0, 200}, 20, false);
    ASSERT_GE(chosen.size(), 18u);
    // A tenth of the path is time, so a camera that rests half the time gets a twentieth of the frames: one or two.
    EXPECT_LE(std::count_if(chosen.begin(), chosen.end(), [](size_t i) { return i >= 100; }), 2);
    EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
}

TEST(ChooseFrames, takeTheSharpestNearby) {
    auto frames = steady(100, 0.01, 0);
    for (size_t i = 0; i < 100; ++i)
        if (i % 5 != 3) frames[i].sharpness = 20;  // only every fifth is sharp
    for (size_t i : chooseFrames(frames, {0, 100}, 10, false)) EXPECT_EQ(i % 5, 3u);
}

TEST(ChooseFrames, posesCountInMotion) {
    auto frames = steady(200, 0, 0);
    for (size_t i = 150; i < 200; ++i) frames[i].poseChange = 0.01;
    const auto still = chooseFrames(frames, {0, 200}, 20, false), moving = chooseFrames(frames, {0, 200}, 20, true);
    const auto late = [](const std::vector<size_t>& list) {
        return std::count_if(list.begin(), list.end(), [](size_t i) { return i >= 150; });
    };
    EXPECT_LE(late(still), 6);    // by time alone: a quarter
    EXPECT_GE(late(moving), 16);  // where the poses are
}

TEST(ChooseFrames, spansAndShortVideos) {
    const auto frames = steady(50, 0.01, 0);
    EXPECT_EQ(chooseFrames(frames, {10, 14}, 20, false), (std::vector<size_t>{10, 11, 12, 13}));
    for (size_t i : chooseFrames(frames, {20, 40}, 5, false)) EXPECT_TRUE(i >= 20 && i < 40);
    EXPECT_TRUE(chooseFrames(frames, {7, 7}, 5, false).empty());
}

TEST(SplitByMotion, findsTheMomentInEitherOrder) {
    auto frames = steady(240, 0.01, 0.00005);
    for (size_t i = 100; i < 240; ++i) frames[i].poseChange = 0.0004;
    const StillAndMoving parts = splitByMotion(frames);
    EXPECT_EQ(parts.still.begin, 0u);
    EXPECT_NEAR(double(parts.still.end), 100, 1);
    EXPECT_EQ(parts.moving.end, 240u);
    std::reverse(frames.begin(), frames.end());
    for (size_t i = 0; i < frames.size(); ++i) frames[i].timeS = double(i) / 12;
    const StillAndMoving turned = splitByMotion(frames);
    EXPECT_EQ(turned.moving.begin, 0u);
    EXPECT_NEAR(double(turned.moving.end), 140, 1);
}

TEST(SplitByMotion, evenVideosAreOneThing) {
    const StillAndMoving still = splitByMotion(steady(240, 0.01, 0.00005));
    EXPECT_EQ(still.still.end - still.still.begin, 240u);
    const StillAndMoving moving = splitByMotion(steady(240, 0.01, 0.0004));
    EXPECT_EQ(moving.moving.end - moving.moving.begin, 240u);
    EXPECT_FALSE(moving.cameraRests);
}

TEST(SplitByMotion, aRestingCameraFilmsMotionHoweverSmallThePersonIs) {
    const auto isMotion = [](const std::vector<FrameMotion>& frames) {
        const StillAndMoving parts = splitByMotion(frames);
        return parts.cameraRests && parts.still.end == parts.still.begin && parts.moving.end == frames.size();
    };
    auto hand = steady(120, 0.0005, 0.00002);
    for (size_t i = 0; i < hand.size(); ++i) hand[i].stayed = i < 42 ? -1 : 0.9;
    EXPECT_TRUE(isMotion(hand));
    auto tripod = steady(20, 0.00001, 0.00002);  // too short to know what stays
    for (FrameMotion& frame : tripod) frame.stayed = -1;
    EXPECT_TRUE(isMotion(tripod));
}

TEST(SplitByMotion, aWalkBeforeARestingCameraIsTheStillPart) {
    auto frames = steady(240, 0.001, 0.00005);
    for (size_t i = 0; i < 240; ++i) frames[i].stayed = i < 42 ? -1 : i < 150 ? 0.2 : 0.8;  // rests from 129 on
    const StillAndMoving parts = splitByMotion(frames);
    EXPECT_EQ(parts.still.begin, 0u);
    EXPECT_NEAR(double(parts.still.end), 129, 1);
    EXPECT_EQ(parts.moving.end, 240u);
}

TEST(SplitByMotion, framesTooFarApartAreNotGuessed) {
    auto frames = steady(100, 0.05, 0.003);
    for (size_t i = 0; i < 60; ++i) frames[i].followed = false;
    const StillAndMoving parts = splitByMotion(frames);
    EXPECT_FALSE(parts.followed);
    EXPECT_EQ(parts.still.end, 100u);
    // A few such frames say nothing, and do not hide the others.
    frames = steady(240, 0.01, 0.00005);
    for (size_t i = 100; i < 240; ++i) frames[i].poseChange = 0.0004;
    for (size_t i = 20; i < 40; ++i) frames[i].followed = false, frames[i].poseChange = 0.01;
    EXPECT_NEAR(double(splitByMotion(frames).still.end), 100, 2);
}

/** A room of texture at three depths that slides past, about `slide` px a frame, with a subject in front that slides slower, and limbs that
 *  swing. `subjectWidth`, px. */
cv::Mat scene(int frame, bool swinging, int slide = 3, int subjectWidth = 60) {
    static const cv::Mat noise = [] {
        cv::Mat fine(400, 900, CV_8U), smooth;
        cv::RNG random(7);
        random.fill(fine, cv::RNG::UNIFORM, 0, 255);
        cv::GaussianBlur(fine, smooth, {7, 7}, 2);
        cv::normalize(smooth, smooth, 20, 235, cv::NORM_MINMAX);
        return smooth;
    }();
    const int width = 270, height = 360;
    cv::Mat picture(height, width, CV_8U);
    for (int band = 0; band < 3; ++band)
        noise(cv::Rect(10 + frame * slide * (2 + band) / 3, 20 + 120 * band, width, 120))
            .copyTo(picture(cv::Rect(0, 120 * band, width, 120)));
    const auto paste = [&](cv::Rect at, int seed) { noise(cv::Rect(seed, 0, at.width, at.height)).copyTo(picture(at)); };
    paste({140 - subjectWidth / 2 - (slide ? frame / 4 : 0), 80, subjectWidth, 240}, 500);
    if (subjectWidth > 100) return picture;
    const int swing = swinging ? int(std::lround(14 * std::sin(frame * 0.6))) : 0;
    paste({60, 120 + swing, 45, 70}, 620);
    paste({180, 120 - swing, 45, 70}, 700);
    return picture;
}

template <class Scene>
std::vector<FrameMotion> measured(int count, Scene&& picture) {
    MotionMeter meter(270, 360);
    std::vector<FrameMotion> frames;
    for (int i = 0; i < count; ++i) {
        const cv::Mat made = picture(i);
        frames.push_back(meter.add({made.data, made.total()}, i / 12.0));
    }
    return frames;
}

TEST(MotionMeter, tellsASwingingSubjectFromAMovingCamera) {
    const auto frames = measured(80, [](int i) { return scene(i, i >= 40); });
    const double diagonal = std::hypot(270.0, 360.0);
    EXPECT_NEAR(frames[20].cameraMotion, 3 / diagonal, 1.1 / diagonal);  // the room slides by 2 to 4 px a frame
    const StillAndMoving parts = splitByMotion(frames);
    double still = 0, swinging = 0;
    for (size_t i = 2; i < 80; ++i) (i < 40 ? still : swinging) += frames[i].poseChange / 39;
    EXPECT_GT(swinging, 3 * still) << still << ' ' << swinging;
    EXPECT_EQ(parts.still.begin, 0u);
    EXPECT_NEAR(double(parts.still.end), 40, 3);
    EXPECT_EQ(parts.moving.end, 80u);
}

TEST(MotionMeter, theRoomBehindALargeStillSubjectIsNoMotion) {
    // The subject fills half of the picture and stays in its middle, while the camera walks.
    const auto frames = measured(60, [](int i) { return scene(i, false, 3, 190); });
    double mean = 0;
    for (const FrameMotion& frame : frames) mean += frame.poseChange / 60;
    EXPECT_LT(mean, 0.0001);
    EXPECT_EQ(splitByMotion(frames).still.end, 60u);
}

TEST(MotionMeter, knowsWhetherTheCameraStays) {
    const auto resting = measured(48, [](int i) { return scene(i, true, 0); });
    EXPECT_LT(resting[20].stayed, 0) << "too early";
    EXPECT_GT(resting.back().stayed, 0.5);
    EXPECT_TRUE(splitByMotion(resting).cameraRests);
    const auto walking = measured(48, [](int i) { return scene(i, true); });
    EXPECT_GE(walking.back().stayed, 0);
    EXPECT_LT(walking.back().stayed, 0.3);
    EXPECT_FALSE(splitByMotion(walking).cameraRests);
}

TEST(MotionMeter, jumpsAreNotFollowed) {
    EXPECT_FALSE(measured(6, [](int i) { return scene(i * 30, false); }).back().followed);  // 90 px a frame
    EXPECT_TRUE(measured(6, [](int i) { return scene(i, false); }).back().followed);
}

TEST(MotionMeter, blurLowersSharpness) {
    MotionMeter meter(270, 360);
    const cv::Mat sharp = scene(0, false);
    cv::Mat blurred;
    cv::blur(sharp, blurred, {5, 1});  // the camera moved by 5 px
    const double a = meter.add({sharp.data, sharp.total()}, 0).sharpness, b = meter.add({blurred.data, blurred.total()}, 0.1).sharpness;
    EXPECT_LT(b, 0.6 * a);
}

}  // namespace
}  // namespace dpl
