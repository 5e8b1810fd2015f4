// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <thread>

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

TEST_F(Files, aNameOutsideAsciiIsOpenedAndNamed) {
    const std::filesystem::path folder = folder_ / u8"Größe 大きさ";
    std::filesystem::create_directories(folder);
    ASSERT_TRUE(writeFileAtomically(folder / u8"жест.bin", "first"));
    ASSERT_TRUE(writeFileAtomically(folder / u8"жест.bin", "second"));
    const auto bytes = readFile(folder / u8"жест.bin");
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(std::string(bytes->begin(), bytes->end()), "second");
    EXPECT_TRUE(std::filesystem::exists(folder / u8"жест.bin")) << "under the name asked for";
    const auto missing = readFile(folder / u8"нет.bin");
    ASSERT_FALSE(missing);
    const std::string name = reinterpret_cast<const char*>(u8"Größe 大きさ");
    EXPECT_NE(missing.error().message.find(name), std::string::npos) << missing.error().message;
}

TEST_F(Files, aFolderOfThatNameIsAnErrorAndStays) {
    std::filesystem::create_directories(folder_ / "a" / "b");
    const Status written = writeFileAtomically(folder_ / "a", "x");
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("cannot rename to"), std::string::npos) << written.error().message;
    EXPECT_TRUE(std::filesystem::is_directory(folder_ / "a" / "b"));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1) << "no temporary is left";
}

TEST_F(Files, refusesMoreThanTheLimitAndFolders) {
    ASSERT_TRUE(writeFileAtomically(folder_ / "a", "12345"));
    EXPECT_FALSE(readFile(folder_ / "a", 4));
    EXPECT_TRUE(readFile(folder_ / "a", 5));
    EXPECT_FALSE(readFile(folder_));
}

std::filesystem::path growing;  // a CheckFileHead holds no state

TEST_F(Files, aFileThatGrowsWhileItIsReadIsRefused) {
    growing = folder_ / "a";
    ASSERT_TRUE(writeFileAtomically(growing, std::string(2 * kFileHeadBytes, 'a')));
    const auto grow = [](std::span<const uint8_t>, uint64_t fileBytes) {
        std::filesystem::resize_file(growing, fileBytes + 1);
        return Status();
    };
    const auto bytes = readFile(growing, kMaxFileBytes, grow);
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().code, Code::CorruptData);
    EXPECT_NE(bytes.error().message.find("longer while it was read"), std::string::npos) << bytes.error().message;
}

TEST_F(Files, aFileThatIsAcceptedIsReadWhole) {
    const std::string text(3 * kFileHeadBytes + 7, 'a');
    ASSERT_TRUE(writeFileAtomically(folder_ / "a", text));
    const auto bytes = readFile(folder_ / "a", text.size(), [](std::span<const uint8_t>, uint64_t) { return Status(); });
    ASSERT_TRUE(bytes);
    EXPECT_EQ(std::string(bytes->begin(), bytes->end()), text);
}

#if !defined(_WIN32)  // sparse files, pipes, devices and links as POSIX has them
TEST_F(Files, fullDiskLeavesTheOldFileAlone) {
    if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "/dev/full is not there";
    // The temporary file cannot be created in the target's folder; this stands for a full disk.
    auto status = writeFileAtomically("/dev/full/x", "1");
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("/dev/full/x"), std::string::npos);
}

TEST_F(Files, aLinkStaysALinkAndItsFileIsReplaced) {
    ASSERT_TRUE(writeFileAtomically(folder_ / "file", "old"));
    std::filesystem::create_symlink("file", folder_ / "link");
    ASSERT_TRUE(writeFileAtomically(folder_ / "link", "new"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link"));
    const auto bytes = readFile(folder_ / "file");
    ASSERT_TRUE(bytes);
    EXPECT_EQ(std::string(bytes->begin(), bytes->end()), "new");
}

TEST_F(Files, aDanglingLinkCreatesItsTarget) {
    std::filesystem::create_symlink("later", folder_ / "link");
    ASSERT_TRUE(writeFileAtomically(folder_ / "link", "made"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link"));
    EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "later"));
}

TEST_F(Files, aPipeIsWrittenToAndNotReplaced) {
    const std::filesystem::path pipe = folder_ / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    std::string got(3, ' ');
    std::thread reader([&] {
        const int fd = ::open(pipe.c_str(), O_RDONLY);
        for (size_t done = 0; done < got.size();) {
            const ssize_t n = ::read(fd, got.data() + done, got.size() - done);
            if (n <= 0) break;
            done += size_t(n);
        }
        ::close(fd);
    });
    const Status written = writeFileAtomically(pipe, "abc");
    reader.join();
    EXPECT_TRUE(written);
    EXPECT_EQ(got, "abc");
    EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST_F(Files, aPipeIsRefusedAndNobodyWaitsForItsWriter) {
    const std::filesystem::path pipe = folder_ / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const auto bytes = readFile(pipe);
    ASSERT_FALSE(bytes);
    EXPECT_NE(bytes.error().message.find("is not a file"), std::string::npos) << bytes.error().message;
}

TEST_F(Files, aFullDeviceIsAnErrorAndStaysADevice) {
    if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "/dev/full is not there";
    std::filesystem::create_symlink("/dev/full", folder_ / "full");
    const Status written = writeFileAtomically(folder_ / "full", "x");
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("No space left"), std::string::npos) << written.error().message;
    EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST_F(Files, aFileIsRefusedByItsFirstBytes) {
    // A sparse file of 8 TiB, far too large to read.
    const std::filesystem::path huge = folder_ / "huge";
    ASSERT_TRUE(writeFileAtomically(huge, "wrong"));
    std::filesystem::resize_file(huge, uint64_t(8) << 40);
    const auto refuse = [](std::span<const uint8_t> head, uint64_t fileBytes) -> Status {
        EXPECT_EQ(head.size(), kFileHeadBytes);
        return fail(Code::Unsupported, "{} of {} bytes seen", head.size(), fileBytes);
    };
    const auto bytes = readFile(huge, UINT64_MAX, refuse);
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().code, Code::Unsupported);
    EXPECT_NE(bytes.error().message.find("huge"), std::string::npos);
}
#endif

}  // namespace
