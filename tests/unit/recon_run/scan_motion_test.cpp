// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/scan_motion.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;

TEST(ScanMotion, playsMovingFramesInTheirOrderAndLeavesOutJointsAtRest) {
    Scan scan;
    scan.frames.resize(4);
    const double times[] = {2, 0, 1, 1};
    std::vector<Pose> poses;
    for (size_t f = 0; f < 4; ++f) {
        scan.frames[f].kind = FrameKind::Dynamic, scan.frames[f].timeS = times[f];
        poses.push_back(Pose::rest(3));
        poses[f].localRotations[1] = glm::angleAxis(0.2f * float(f), Vec3f(1, 0, 0));
        poses[f].localRotations[2] = -Quatf(1, 0, 0, 0);  // rest too
    }
    scan.frames[3].kind = FrameKind::StaticFull;
    const std::vector<size_t> frames = {0, 1, 2, 3};
    const std::vector<ClipData> clips = scanMotion(scan, frames, poses);
    ASSERT_EQ(clips.size(), 1u);
    EXPECT_EQ(clips[0].timesS, (std::vector<float>{0, 1, 2}));
    ASSERT_EQ(clips[0].channels.size(), 1u) << "only joint 1 moves";
    EXPECT_EQ(clips[0].channels[0].joint, 1u);
    EXPECT_EQ(clips[0].channels[0].rotations.back(), poses[0].localRotations[1]);
    EXPECT_TRUE(scanMotion(scan, std::span(frames).first(1), std::span(poses).first(1)).empty());
}

}  // namespace
