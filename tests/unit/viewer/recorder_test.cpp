// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/recorder.h"

#include <gtest/gtest.h>

#include <numbers>

#include "reconstruction/base/image_codec.h"
#include "sdk/core/files.h"

namespace {

using namespace dpl;
namespace fs = std::filesystem;

class RecorderTest : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("doppel-recorder-" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
                                               "-" + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    size_t entries() const { return size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator())); }

    fs::path folder_;
};

std::vector<uint8_t> plain(uint32_t width, uint32_t height, uint8_t value) {
    return std::vector<uint8_t>(size_t(width) * height * 3, value);
}

TEST_F(RecorderTest, turntableTurnsOnceAndAppearsWhenComplete) {
    const fs::path out = folder_ / "turn";
    auto turn = Recording::begin(out, 4, 5, 3, 30);
    ASSERT_TRUE(turn) << turn.error().message;
    for (uint32_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(turn->turnRad(), i * std::numbers::pi / 2, 1e-12);
        EXPECT_FALSE(fs::exists(out));
        ASSERT_TRUE(turn->add(plain(5, 3, uint8_t(10 * i)), 5, 3));
    }
    EXPECT_EQ(turn->done(), turn->frames());
    for (uint32_t i = 0; i < 4; ++i) {
        const auto file = readFile(out / ("0000" + std::to_string(i) + ".png"));
        ASSERT_TRUE(file);
        const auto picture = decodePicture(*file, PictureChannels::AsStored);
        ASSERT_TRUE(picture);
        EXPECT_EQ(picture->widthPx, 5u);
        EXPECT_EQ(picture->heightPx, 3u);
        EXPECT_EQ(picture->pixels, plain(5, 3, uint8_t(10 * i)));
    }
    EXPECT_EQ(entries(), 1u);
}

TEST_F(RecorderTest, anotherSizeEndsTheRecordingAndLeavesNothing) {
    {
        auto turn = Recording::begin(folder_ / "turn", 3, 4, 4, 30);
        ASSERT_TRUE(turn);
        ASSERT_TRUE(turn->add(plain(4, 4, 0), 4, 4));
        const Status added = turn->add(plain(6, 4, 0), 6, 4);
        ASSERT_FALSE(added);
        EXPECT_NE(added.error().message.find("another size"), std::string::npos);
    }
    EXPECT_EQ(entries(), 0u);
}

TEST_F(RecorderTest, existingFoldersAreKept) {
    fs::create_directories(folder_ / "turn");
    const auto turn = Recording::begin(folder_ / "turn", 3, 4, 4, 30);
    ASSERT_FALSE(turn);
    EXPECT_NE(turn.error().message.find("exists already"), std::string::npos);
    EXPECT_TRUE(fs::exists(folder_ / "turn"));
}

TEST_F(RecorderTest, freeNamesAreCounted) {
    const std::string prefix = (folder_ / "shot").string();
    EXPECT_EQ(nextFreeName(prefix, ".png"), prefix + "-1.png");
    ASSERT_TRUE(writeScreenshot(prefix + "-1.png", plain(2, 2, 7), 2, 2));
    EXPECT_EQ(nextFreeName(prefix, ".png"), prefix + "-2.png");
}

TEST_F(RecorderTest, aFolderThatIsNotThereIsAnError) {
    const Status written = writeScreenshot(folder_ / "none" / "shot.png", plain(2, 2, 7), 2, 2);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("shot.png"), std::string::npos);
}

}  // namespace
