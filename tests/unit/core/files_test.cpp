// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/files.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace {

using namespace dpl;

class Files : public testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("doppel_files_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    std::filesystem::path folder_;
};

TEST_F(Files, readsBackWhatWasWritten) {
    ASSERT_TRUE(writeFileAtomically(folder_ / "a", "three\0bytes"));
    ASSERT_TRUE(writeFileAtomically(folder_ / "a", "second"));
    auto bytes = readFile(folder_ / "a");
    ASSERT_TRUE(bytes);
    EXPECT_EQ(std::string(bytes->begin(), bytes->end()), "second");
}

TEST_F(Files, leavesNoTemporaryBehind) {
    ASSERT_TRUE(writeFileAtomically(folder_ / "a", "x"));
    size_t entries = 0;
    for ([[maybe_unused]] auto& entry : std::filesystem::directory_iterator(folder_)) ++entries;
    EXPECT_EQ(entries, 1u);
}

TEST_F(Files, missingFileIsNotFoundAndNamed) {
    auto bytes = readFile(folder_ / "nowhere");
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().code, Code::NotFound);
    EXPECT_NE(bytes.error().message.find("nowhere"), std::string::npos);
}

TEST_F(Files, refusesMoreThanTheLimitAndFolders) {
    ASSERT_TRUE(writeFileAtomically(folder_ / "a", "12345"));
    EXPECT_FALSE(readFile(folder_ / "a", 4));
    EXPECT_TRUE(readFile(folder_ / "a", 5));
    EXPECT_FALSE(readFile(folder_));
}

TEST_F(Files, fullDiskLeavesTheOldFileAlone) {
    if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "/dev/full is not there";
    // A target whose folder cannot take the temporary stands in for a disk that cannot.
    auto status = writeFileAtomically("/dev/full/x", "1");
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("/dev/full/x"), std::string::npos);
}

}  // namespace
