// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/scan_inputs.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;

TEST(ScanInputs, posesDependOnCamerasTimesAndKeypointsOfHeldOutFramesToo) {
    Scan scan;
    scan.frames.resize(2);
    scan.frames[0].name = "shown", scan.frames[1].name = "held_out", scan.frames[1].split = Split::Test;
    std::vector<FrameHashes> hashes(2);
    const auto before = posedInputs(scan, hashes);
    hashes[1].image = hashes[1].mask = hashes[1].labels = "another";
    EXPECT_EQ(posedInputs(scan, hashes), before) << "no picture decides a held-out pose before the pose fit";
    scan.frames[1].camera.cx += 1;
    EXPECT_NE(posedInputs(scan, hashes), before) << "camera";
    scan.frames[1].camera.cx -= 1, scan.frames[1].timeS += 3;
    EXPECT_NE(posedInputs(scan, hashes), before) << "time";
    scan.frames[1].timeS -= 3, hashes[1].keypoints = "another";
    EXPECT_NE(posedInputs(scan, hashes), before) << "keypoints";
}

}  // namespace
