// SPDX-License-Identifier: Apache-2.0
// doppel_png.h against libpng, which checks every chunk, and against zlib's checksum of the rows.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <random>

#include "reconstruction/base/image_codec.h"
#include "sdk/core/files.h"
#include "sdk/include/doppel/doppel_png.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

class Png : public testing::Test {
protected:
    void SetUp() override {
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string path(const char* name) const { return (folder_ / name).string(); }
    size_t files() const { return size_t(std::distance(fs::directory_iterator(folder_), {})); }
    const fs::path folder_ = fs::path(testing::TempDir()) / "doppel_png_test";
};

std::vector<uint8_t> noise(uint32_t widthPx, uint32_t heightPx) {
    std::mt19937 random(widthPx);
    std::vector<uint8_t> rgba(size_t(widthPx) * heightPx * 4);
    for (uint8_t& byte : rgba) byte = uint8_t(random());
    return rgba;
}

TEST_F(Png, isReadBackWithEqualPixels) {
    // A block has at most 65,535 bytes. 8192 x 2 px have 65,538, 5461 x 3 exactly 65,535.
    const std::vector<std::pair<uint32_t, uint32_t>> sizes = {{1, 1}, {3, 2}, {512, 768}, {8192, 2}, {5461, 3}, {2, 8192}};
    for (const auto& [widthPx, heightPx] : sizes) {
        const auto rgba = noise(widthPx, heightPx);
        ASSERT_EQ(dplWritePng(path("a.png").c_str(), rgba.data(), widthPx, heightPx), DPL_OK) << std::strerror(errno);
        EXPECT_EQ(files(), 1u) << "the other name is gone";
        const auto bytes = readFile(folder_ / "a.png");
        ASSERT_TRUE(bytes) << bytes.error().message;
        const auto read = decodePicture(*bytes, PictureChannels::AsStored);
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(read->widthPx, widthPx);
        EXPECT_EQ(read->heightPx, heightPx);
        EXPECT_EQ(read->channels, 4u);
        EXPECT_TRUE(read->pixels == rgba) << widthPx << " x " << heightPx;

        constexpr size_t kDataAt = 8 + 25 + 8, kAfterData = 4 + 12;  // signature, IHDR, head of IDAT; its CRC, IEND
        std::vector<uint8_t> rows((4 * size_t(widthPx) + 1) * heightPx + 1);
        uLongf rowBytes = uLongf(rows.size());
        ASSERT_EQ(uncompress(rows.data(), &rowBytes, bytes->data() + kDataAt, uLong(bytes->size() - kDataAt - kAfterData)), Z_OK);
        EXPECT_EQ(rowBytes, rows.size() - 1);
    }
}

TEST_F(Png, replacesAnOlderFile) {
    const auto rgba = noise(3, 2);
    ASSERT_TRUE(writeFileAtomically(folder_ / "a.png", "old"));
    ASSERT_EQ(dplWritePng(path("a.png").c_str(), rgba.data(), 3, 2), DPL_OK);
    EXPECT_TRUE(decodePicture(*readFile(folder_ / "a.png"), PictureChannels::AsStored));
    EXPECT_EQ(files(), 1u);
}

TEST_F(Png, refusesWhatIsNoPicture) {
    const uint8_t pixel[4] = {};
    const std::string name = path("a.png");
    EXPECT_EQ(dplWritePng(nullptr, pixel, 1, 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplWritePng(name.c_str(), nullptr, 1, 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplWritePng(name.c_str(), pixel, 0, 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplWritePng(name.c_str(), pixel, 1, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplWritePng(name.c_str(), pixel, 8193, 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplWritePng(name.c_str(), pixel, 1, 0x40000001), DPL_ERROR_INVALID_ARGUMENT) << "4 times that is 4 in 32 bits";
    EXPECT_EQ(dplWritePng(name.c_str(), pixel, UINT32_MAX, UINT32_MAX), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(files(), 0u);
}

TEST_F(Png, aFileThatCannotBeWrittenIsAnErrorWithItsReason) {
    const uint8_t pixel[4] = {};
    EXPECT_EQ(dplWritePng((folder_ / "none" / "a.png").string().c_str(), pixel, 1, 1), DPL_ERROR_IO);
    EXPECT_EQ(errno, ENOENT);
    fs::create_directories(folder_ / "full" / "inside");
    EXPECT_EQ(dplWritePng(path("full").c_str(), pixel, 1, 1), DPL_ERROR_IO);
    EXPECT_EQ(errno, EISDIR);
    EXPECT_TRUE(fs::is_directory(folder_ / "full" / "inside"));
    EXPECT_EQ(files(), 1u) << "the other name is gone";
    if (fs::exists("/dev/full")) {  // every write to it fails as on a full disk
        fs::create_symlink("/dev/full", folder_ / "b.png.part");
        const auto rgba = noise(64, 64);  // more than the buffer of a FILE
        EXPECT_EQ(dplWritePng(path("b.png").c_str(), rgba.data(), 64, 64), DPL_ERROR_IO);
        EXPECT_EQ(errno, ENOSPC);
        EXPECT_FALSE(fs::exists(folder_ / "b.png"));
        EXPECT_FALSE(fs::is_symlink(folder_ / "b.png.part"));
    }
}

}  // namespace
}  // namespace dpl
