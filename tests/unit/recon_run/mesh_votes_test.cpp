// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "reconstruction/run/mesh_votes.h"

namespace dpl {
namespace {

constexpr double kFocalPx = 500;

std::vector<JointData> pole(size_t joints) {
    std::vector<JointData> rig;
    for (size_t j = 0; j < joints; ++j) rig.push_back({"joint" + std::to_string(j), int32_t(j) - 1, {0, 0.2f * float(j), 0}, ""});
    return rig;
}

/** A camera that looks along −z at (0, heightM, 0) from distanceM. */
TrainFrame frameAt(double distanceM, double heightM, uint32_t sizePx, size_t joints) {
    TrainFrame f;
    f.camera = {
        sizePx, sizePx, kFocalPx, kFocalPx, sizePx / 2.0, sizePx / 2.0, Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1), Vec3d(0, heightM, distanceM)};
    f.pose = Pose::rest(joints);
    return f;
}

TEST(TrainedPixel, isThatOfTheFramesThatShowTheBody) {
    const auto rig = pole(10);
    std::vector<TrainFrame> frames;
    for (const double distanceM : {3.0, 2.6, 2.8, 2.7, 2.9}) frames.push_back(frameAt(distanceM, 0.9, 600, 10));
    EXPECT_NEAR(trainedPixelM(rig, frames), 2.8 / kFocalPx, 1e-6);
    for (int i = 0; i < 12; ++i) frames.push_back(frameAt(0.4, 1.8, 100, 10));  // twice as many close-ups of the last joint
    EXPECT_NEAR(trainedPixelM(rig, frames), 2.7 / kFocalPx, 1e-6) << "50 joints at 2.6 to 3 m against 12 at 0.4 m";
}

TEST(TrainedPixel, isThatOfTheCloseUpsWhenThereIsNothingElse) {
    EXPECT_NEAR(trainedPixelM(pole(10), {frameAt(0.4, 1.8, 100, 10)}), 0.4 / kFocalPx, 1e-6);
}

TEST(TrainedPixel, isNotKnownWhereNoJointIsSeen) {
    EXPECT_EQ(trainedPixelM(pole(3), {}), 0);
    EXPECT_EQ(trainedPixelM(pole(3), {frameAt(-2, 0.2, 600, 3)}), 0) << "behind the camera";
    EXPECT_EQ(trainedPixelM(pole(3), {frameAt(2, 50, 100, 3)}), 0) << "beside the picture";
}

TEST(TrainedPixel, followsTheRoot) {
    TrainFrame f = frameAt(3, 0.9, 600, 10);
    f.pose.rootTranslation = {0, 0, 1};  // towards the camera
    EXPECT_NEAR(trainedPixelM(pole(10), {f}), 2 / kFocalPx, 1e-6);
}

}  // namespace
}  // namespace dpl
