// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/scan_frames.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "sdk/core/files.h"
#include "tests/unit/must.h"

namespace {

using namespace dpl;
namespace fs = std::filesystem;

const std::string kFrames = R"({"format":"doppel-frames","version":1,"scan":"scan","frames":[
{"name":"full_000","image":"images/a.png","mask":"","size":[640,480],"camera":[500,500,320,240,1,0,0,0,1,0,0,0,1,0,-1,2]},
{"name":"dyn_000","image":"/else/b.png","mask":"masks/b.png","size":[640,480],"camera":[500,500,320,240,0,1,0,-1,0,0,0,0,1,0,0,2],"distortion":[-0.1,0.02,0,0.001]},
{"name":"unposed","image":"c.png","size":[640,480],"camera":[500,500,320,240,1,0,0,0,1,0,0,0,1,0,0,2]}]})";
const std::string kPoses = R"({"format":"doppel-poses","version":1,"joints":["pelvis","arm"],"rest_positions":[[0,1,0],[0,1.2,0]],"frames":[
{"name":"full_000","kind":"static_full","split":"train","pose":{"rotations_xyzw":[[0,0,0,1],[0,0,0,1]],"root_translation":[0,0.5,0]}},
{"name":"dyn_000","kind":"dynamic","split":"test","pose":{"rotations_xyzw":[[0,0,0,1],[0,0,0,1]],"root_translation":[9,9,9]},
 "fitted_pose":{"rotations_xyzw":[[0,0,0,1],[0,1,0,0]],"root_translation":[1,2,3]}}]})";

class ScanFramesTest : public ::testing::Test {
protected:
    void SetUp() override { fs::create_directories(out_); }
    void TearDown() override { fs::remove_all(out_); }
    Result<ScanFrames> read(const std::string& frames, const std::string& poses) {
        EXPECT_TRUE(writeFileAtomically(out_ / "frames.json", std::string_view(frames)));
        EXPECT_TRUE(writeFileAtomically(out_ / "poses.json", std::string_view(poses)));
        return readScanFrames(out_);
    }
    static std::string with(std::string text, const std::string& part, const std::string& other) {
        const size_t at = text.find(part);
        EXPECT_NE(at, std::string::npos) << part;
        return text.replace(at, part.size(), other);
    }
    const fs::path out_ = fs::temp_directory_path() / ("doppel-scan-frames-" + std::to_string(::getpid()));
};

TEST_F(ScanFramesTest, joinsCamerasAndPosesByName) {
    EXPECT_FALSE(hasScanFrames(out_));
    const ScanFrames frames = must(read(kFrames, kPoses));
    EXPECT_TRUE(hasScanFrames(out_));
    EXPECT_EQ(frames.scan, out_ / "scan");
    EXPECT_EQ(frames.joints, (std::vector<std::string>{"pelvis", "arm"}));
    ASSERT_EQ(frames.frames.size(), 2u) << "a frame without a pose is left out";
    const ComparedFrame &still = frames.frames[0], &moving = frames.frames[1];
    EXPECT_EQ(still.name, "full_000");
    EXPECT_EQ(still.root[1], 0.5f);
    EXPECT_EQ(still.camera.viewFromWorldTranslation, Vec3d(0, -1, 2));
    EXPECT_EQ(moving.split, "test");
    EXPECT_EQ(moving.rotations, (std::vector<float>{0, 0, 0, 1, 0, 1, 0, 0})) << "the fitted pose";
    EXPECT_EQ(moving.root[0], 1.0f);
    EXPECT_EQ(moving.camera.viewFromWorldRotation[0], Vec3d(0, 1, 0)) << "by columns";
    EXPECT_EQ(moving.k1, -0.1);
    EXPECT_EQ(moving.p2, 0.001);
}

TEST_F(ScanFramesTest, refusesEveryBeginningOfAFile) {
    for (size_t length = 0; length < kFrames.size(); length += 7) EXPECT_FALSE(read(kFrames.substr(0, length), kPoses)) << length;
    for (size_t length = 0; length < kPoses.size(); length += 7) EXPECT_FALSE(read(kFrames, kPoses.substr(0, length))) << length;
}

TEST_F(ScanFramesTest, refusesWhatNoRunWrites) {
    for (const auto& [part, other] : {std::pair<std::string, std::string>{"doppel-frames", "doppel-poses"},
                                      {"\"version\":1", "\"version\":2"},
                                      {"\"scan\":\"scan\"", "\"scan\":\"\""},
                                      {"[640,480]", "[640]"},
                                      {"[640,480]", "[0,480]"},
                                      {"[640,480]", "[60000,60000]"},
                                      {"[640,480]", "[1e999,480]"},
                                      {"[500,500,", "[-500,500,"},
                                      {"[500,500,", "[null,500,"},
                                      {"1,0,0,0,1,0,0,0,1,0,-1,2", "1,0,0,0,1,0,0,0,1,0,-1"},
                                      {"1,0,0,0,1,0,0,0,1,0,-1,2", "1,0,0,0,1,0,0,0,0.5,0,-1,2"},
                                      {"1,0,0,0,1,0,0,0,1,0,-1,2", "1,0,0,0,1,0,0,0,1,0,-1e30,2"},
                                      {"-0.1,0.02", "-1e9,0.02"},
                                      {"\"name\":\"full_000\"", "\"name\":7"}})
        EXPECT_FALSE(read(with(kFrames, part, other), kPoses)) << other;
    for (const auto& [part, other] : {std::pair<std::string, std::string>{"doppel-poses", "doppel-frames"},
                                      {"[\"pelvis\",\"arm\"]", "[\"pelvis\"]"},
                                      {"[\"pelvis\",\"arm\"]", "[1,2]"},
                                      {"[[0,0,0,1],[0,0,0,1]]", "[[0,0,0,1],[0,0,0]]"},
                                      {"[[0,0,0,1],[0,0,0,1]]", "[[0,0,0,1],[0,0,0,1e9]]"},
                                      {"[0,0.5,0]", "[0,1e30,0]"},
                                      {"\"root_translation\":[0,0.5,0]", "\"root\":[0,0.5,0]"},
                                      {"\"full_000\",\"kind\"", "\"other\",\"kind\""},
                                      {"{\"name\":\"full_000\"", "7,{\"name\":\"full_000\""}}) {
        const auto frames = read(kFrames, with(kPoses, part, other));
        if (other == "\"other\",\"kind\"")
            EXPECT_EQ(must(frames).frames.size(), 1u);
        else
            EXPECT_FALSE(frames) << other;
    }
    EXPECT_FALSE(read(with(kFrames, "\"dyn_000\"", "\"x\""), with(kPoses, "\"full_000\"", "\"y\""))) << "nothing in common";
}

}  // namespace
