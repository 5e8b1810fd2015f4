// SPDX-License-Identifier: Apache-2.0
#include "apps/shared/video_writer.h"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
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

/** A file system of so many bytes at a folder, unmounted by the destructor. Needs root. */
struct SmallDisk {
    fs::path path;
    bool mounted = false;
    SmallDisk(const fs::path& at, const char* size) : path(at) {
        fs::create_directories(path);
        mounted = ::mount("doppel-test", path.c_str(), "tmpfs", 0, formatText("size={}", size).c_str()) == 0;
    }
    ~SmallDisk() {
        if (mounted) ::umount(path.c_str());
    }
};

TEST_F(VideoWriterTest, aVideoThatDoesNotFitOnTheDiskIsAnErrorAndLeavesNothing) {
    for (const char* size : {"4k", "16k", "64k"}) {
        const SmallDisk disk(folder_ / size, size);
        if (!disk.mounted) GTEST_SKIP() << "a small disk cannot be mounted here: " << std::strerror(errno);
        auto writer = VideoWriter::open(disk.path / "x.mp4", 64, 48, 25);
        ASSERT_TRUE(writer) << writer.error().message;
        std::mt19937 random(1);
        std::vector<uint8_t> noise = frame_;
        Status written;
        for (int i = 0; i < 60 && written; ++i) {
            for (uint8_t& v : noise) v = uint8_t(random());
            written = writer->write(noise);
        }
        if (written) written = writer->finish();
        ASSERT_FALSE(written) << size;
        EXPECT_EQ(written.error().code, Code::Io);
        EXPECT_NE(written.error().message.find("x.mp4"), std::string::npos) << written.error().message;
        EXPECT_EQ(std::distance(fs::directory_iterator(disk.path), fs::directory_iterator()), 0);
    }
}

/** A program named ffmpeg that is found before the real one. */
struct FakeFfmpeg {
    const std::string path = std::getenv("PATH");
    FakeFfmpeg(const fs::path& folder, const std::string& script) {
        std::ofstream(folder / "ffmpeg") << "#!/bin/sh\n" << script;
        fs::permissions(folder / "ffmpeg", fs::perms::owner_all);
        ::setenv("PATH", (folder.string() + ":" + path).c_str(), 1);
    }
    ~FakeFfmpeg() { ::setenv("PATH", path.c_str(), 1); }
};

TEST_F(VideoWriterTest, aVideoThatFfmpegDidNotCompleteIsAnError) {
    const fs::path real = *findProgram("ffmpeg"), bin = folder_ / "bin";
    fs::create_directories(bin);
    // Ends well as on a full disk, after it has cut the file, dropped its frames, or made another size.
    const std::pair<const char*, std::string> faults[] = {
        {"cut",
         "case \"$*\" in *pipe:0*) \"$REAL\" \"$@\"; for f; do :; done; truncate -s 600 \"${f#file:}\";; *) exec \"$REAL\" \"$@\";; "
         "esac\n"},
        {"two frames of five",
         "case \"$*\" in *pipe:0*) for f; do :; done; \"$REAL\" -loglevel error -y -f lavfi -i "
         "testsrc=s=64x48:r=25 -frames:v 2 -pix_fmt yuv420p \"$f\"; cat > /dev/null;; *) exec \"$REAL\" \"$@\";; esac\n"},
        {"another size",
         "case \"$*\" in *pipe:0*) for f; do :; done; \"$REAL\" -loglevel error -y -f lavfi -i "
         "testsrc=s=32x32:r=25 -frames:v 5 -pix_fmt yuv420p \"$f\"; cat > /dev/null;; *) exec \"$REAL\" \"$@\";; esac\n"}};
    ::setenv("REAL", real.c_str(), 1);
    for (const auto& [name, script] : faults) {
        const FakeFfmpeg fake(bin, script);
        auto writer = VideoWriter::open(folder_ / "x.mp4", 64, 48, 25);
        ASSERT_TRUE(writer) << writer.error().message;
        for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer->write(frame_));
        const Status ended = writer->finish();
        ASSERT_FALSE(ended) << name;
        EXPECT_NE(ended.error().message.find("of 5 frames"), std::string::npos) << name << ": " << ended.error().message;
        EXPECT_EQ(filesLeft(), 1u) << name << ": the folder of the program alone";
    }
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
