// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/scan_inputs.h"

#include <gtest/gtest.h>

#include "reconstruction/run/stage.h"
#include "sdk/core/files.h"
#include "tests/unit/recon_capture/scan_builder.h"

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

TEST(ScanInputs, onlyFilesThatAFrameDidNotHaveBeforeAreHashed) {
    const TemporaryFolder folder;
    for (const char* name : {"picture", "mask", "found"}) ASSERT_TRUE(writeFileAtomically(folder.path / name, std::string(name)));
    Scan before;
    before.frames.resize(3);
    for (size_t f = 0; f < 3; ++f)
        before.frames[f].name = std::to_string(f), before.frames[f].imagePath = folder.path / "picture",
        before.frames[f].maskPath = folder.path / "mask";
    const std::vector<FrameHashes> known(3, {"known picture", "known mask", "none", "none"});
    Scan after = before;
    after.frames.erase(after.frames.begin());  // frames are found by name
    after.frames[1].maskPath = folder.path / "found", after.frames[1].name = "2";
    const std::vector<FrameHashes> hashes = hashFrames(after, before, known);
    ASSERT_EQ(hashes.size(), 2u);
    EXPECT_EQ(hashes[0].mask, "known mask");
    EXPECT_EQ(hashes[1].image, "known picture");
    EXPECT_EQ(hashes[1].mask, hashText("found"));
    EXPECT_EQ(hashes[1].keypoints, "none");
}

}  // namespace
