// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_reader.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "sdk/core/files.h"
#include "tests/unit/must.h"

namespace {

using namespace dpl;
namespace fs = std::filesystem;
using Kind = RunLook::Kind;

class RunReaderTest : public ::testing::Test {
protected:
    void SetUp() override {
        fs::remove_all(out_);
        fs::create_directories(out_ / "watch");
    }
    void TearDown() override { fs::remove_all(out_); }
    void tell(const std::string& state, const std::string& rest) {
        write("progress.json", R"({"format":"doppel-progress","version":1,"state":")" + state + "\"" + rest + "}");
    }
    void write(const std::string& name, const std::string& text) { ASSERT_TRUE(writeFileAtomically(out_ / name, std::string_view(text))); }
    const fs::path out_ = fs::temp_directory_path() / ("doppel-run-reader-" + std::to_string(::getpid()));
};

TEST_F(RunReaderTest, tellsARunFromOtherFolders) {
    EXPECT_FALSE(isRunFolder(out_));
    EXPECT_EQ(RunReader(out_).read().look.kind, Kind::NoRun);
    write("run.json", "{}");
    EXPECT_TRUE(isRunFolder(out_));
    EXPECT_EQ(RunReader(out_).read().look.kind, Kind::Untold);
    tell("running", "");
    EXPECT_EQ(RunReader(out_).read().look.kind, Kind::Told);
    write("progress.json", "{\"format\":");
    const auto damaged = RunReader(out_).read();
    EXPECT_EQ(damaged.look.kind, Kind::Damaged);
    EXPECT_NE(damaged.look.sentence.find("progress.json"), std::string::npos);
    fs::remove(out_ / "progress.json");
    fs::create_directory(out_ / "progress.json");
    EXPECT_EQ(RunReader(out_).read().look.kind, Kind::Damaged) << "a folder in its place";
}

TEST_F(RunReaderTest, aDeletedRunIsGone) {
    tell("running", "");
    RunReader reader(out_);
    EXPECT_EQ(reader.read().look.kind, Kind::Told);
    fs::remove_all(out_);
    const auto news = reader.read();
    EXPECT_EQ(news.look.kind, Kind::Gone);
    EXPECT_TRUE(news.avatar.empty());
    EXPECT_NE(news.look.sentence.find("is gone"), std::string::npos);
}

TEST_F(RunReaderTest, eachAvatarIsNewsOnce) {
    RunReader reader(out_);
    const std::string soFar = R"(,"started_unix_s":5,"avatar":{"file":"watch/avatar.glb","step":1,"change":)";
    tell("running", soFar + "1}");
    EXPECT_TRUE(reader.read().avatar.empty()) << "its file is not there";
    write("watch/avatar.glb", "glTF");
    EXPECT_EQ(reader.read().avatar, out_ / "watch/avatar.glb");
    EXPECT_TRUE(reader.read().avatar.empty());
    reader.forgetAvatar();
    EXPECT_EQ(reader.read().avatar, out_ / "watch/avatar.glb") << "it could not be loaded";
    write("avatar.glb", "of an earlier run");
    tell("running", soFar + "2}");
    auto news = reader.read();
    EXPECT_EQ(news.avatar, out_ / "watch/avatar.glb");
    EXPECT_FALSE(news.finished);
    tell("done", soFar + "2}");
    news = reader.read();
    EXPECT_EQ(news.avatar, out_ / "avatar.glb");
    EXPECT_TRUE(news.finished);
    EXPECT_TRUE(reader.read().avatar.empty());
}

TEST_F(RunReaderTest, aFinishedRunOfAnEarlierVersionShowsItsAvatar) {
    write("run.json", "{}");
    write("avatar.glb", "glTF");
    const auto news = RunReader(out_).read();
    EXPECT_EQ(news.avatar, out_ / "avatar.glb");
    EXPECT_TRUE(news.finished);
}

TEST_F(RunReaderTest, opensNoFileOutsideTheRun) {
    std::ofstream(out_.string() + ".glb") << "glTF";
    for (const std::string& path :
         {"../" + out_.filename().string() + ".glb", out_.string() + ".glb", std::string("watch"), std::string("/dev/zero")}) {
        tell("running",
             ",\"avatar\":{\"file\":\"" + path + "\",\"change\":1},\"held_back\":{\"frame\":\"a\",\"picture\":\"" + path + "\"}");
        const auto news = RunReader(out_).read();
        EXPECT_EQ(news.look.kind, Kind::Told);
        EXPECT_TRUE(news.avatar.empty()) << path;
        EXPECT_FALSE(news.heldBack) << path;
    }
    fs::remove(out_.string() + ".glb");
}

TEST_F(RunReaderTest, aHeldBackPictureIsNewsOnceAndADamagedOneIsNone) {
    RunReader reader(out_);
    tell("running", R"(,"held_back":{"frame":"dyn_003","picture":"watch/held-back.jpg"})");
    write("watch/held-back.jpg", "no picture");
    EXPECT_FALSE(reader.read().heldBack);
    const std::vector<uint8_t> pixels(4 * 6 * 3, 77);
    ASSERT_TRUE(writeFileAtomically(out_ / "watch/held-back.jpg", must(encodeJpeg(pixels, 4, 6, 3, 90))));
    const auto news = reader.read();
    ASSERT_TRUE(news.heldBack);
    EXPECT_EQ(news.heldBack->widthPx, 4u);
    EXPECT_EQ(news.heldBack->channels, 4u);
    EXPECT_FALSE(reader.read().heldBack);
}

}  // namespace
