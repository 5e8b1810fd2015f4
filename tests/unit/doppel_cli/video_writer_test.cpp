// SPDX-License-Identifier: Apache-2.0
#include "apps/shared/video_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <vector>

namespace dpl {
namespace {

namespace fs = std::filesystem;

class VideoWriterTest : public testing::Test {
protected:
    void SetUp() override {
        if (!findProgram("ffmpeg") || !findProgram("ffprobe")) GTEST_SKIP() << "ffmpeg is not installed";
        fs::create_directories(folder_);
    }
    ~VideoWriterTest() override { fs::remove_all(folder_); }
    /** What ffprobe says of a video: "width,height,frames". */
    static std::string probed(const fs::path& video) {
        std::string answer;
        const Status ended = runProgram({.arguments = {"ffprobe", "-v", "error", "-count_frames", "-show_entries",
                                                       "stream=width,height,nb_read_frames", "-of", "csv=p=0", "file:" + video.string()},
                                         .line = [&](std::string_view line) { answer = line; }});
        return ended ? answer : ended.error().message;
    }
    size_t filesLeft() const { return size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator())); }
    const fs::path folder_ = fs::temp_directory_path() / ("dpl_video_" + std::to_string(::getpid()));
    const std::vector<uint8_t> frame_ = std::vector<uint8_t>(64 * 48 * 3, 120);
};

TEST_F(VideoWriterTest, writesEveryFrameUnderAnyName) {
    const fs::path path = folder_ / "a $(touch hit); 'b' -y.mp4";
    auto writer = VideoWriter::open(path, 64, 48, 25);
    ASSERT_TRUE(writer) << writer.error().message;
    for (int i = 0; i < 7; ++i) ASSERT_TRUE(writer->write(frame_));
    const Status ended = writer->finish();
    ASSERT_TRUE(ended) << ended.error().message;
    EXPECT_EQ(probed(path), "64,48,7");
    EXPECT_EQ(filesLeft(), 1u);
}

TEST_F(VideoWriterTest, aLinkIsKeptAndItsTargetWritten) {
    fs::create_directories(folder_ / "disk");
    fs::create_symlink("disk/real.mp4", folder_ / "link.mp4");
    auto writer = VideoWriter::open(folder_ / "link.mp4", 64, 48, 25);
    ASSERT_TRUE(writer) << writer.error().message;
    ASSERT_TRUE(writer->write(frame_));
    ASSERT_TRUE(writer->finish());
    EXPECT_TRUE(fs::is_symlink(folder_ / "link.mp4"));
    EXPECT_EQ(probed(folder_ / "disk/real.mp4"), "64,48,1");
}

TEST_F(VideoWriterTest, aDeviceIsRefusedAndKept) {
    fs::create_symlink("/dev/null", folder_ / "null.mp4");
    const auto writer = VideoWriter::open(folder_ / "null.mp4", 64, 48, 25);
    ASSERT_FALSE(writer);
    EXPECT_NE(writer.error().message.find("/dev/null is no place for a video"), std::string::npos) << writer.error().message;
    EXPECT_TRUE(fs::is_symlink(folder_ / "null.mp4"));
}

TEST_F(VideoWriterTest, anUnfinishedVideoLeavesNothing) {
    {
        auto writer = VideoWriter::open(folder_ / "half.mp4", 64, 48, 25);
        ASSERT_TRUE(writer) << writer.error().message;
        ASSERT_TRUE(writer->write(frame_));
    }
    EXPECT_EQ(filesLeft(), 0u);
}

TEST_F(VideoWriterTest, whatFfmpegRefusesIsSaid) {
    auto writer = VideoWriter::open(folder_ / "odd.mp4", 63, 48, 25);  // H.264 with 4:2:0 needs even sides
    ASSERT_TRUE(writer) << writer.error().message;
    Status written = writer->write(frame_);
    if (written) written = writer->finish();
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("odd.mp4"), std::string::npos) << written.error().message;
    EXPECT_NE(written.error().message.find("ffmpeg"), std::string::npos) << written.error().message;
    EXPECT_EQ(filesLeft(), 0u);
}

}  // namespace
}  // namespace dpl
