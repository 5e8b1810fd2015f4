// SPDX-License-Identifier: Apache-2.0
// A COLMAP model as a camera source of a scan: images, optional masks, arbitrary gauge.
#include "reconstruction/input/capture/scan.h"
#include "tests/unit/recon_capture/scan_builder.h"

namespace dpl {
namespace {

void writeModel(const std::filesystem::path& root, const std::string& camera) {
    ScanBuilder builder(root, 12);
    std::string images = "# images\n";
    for (int i = 0; i < 12; ++i)
        images +=
            std::to_string(i + 1) + " 1 0 0 0 0 0 3 1 full_" + std::to_string(100 + i) + ".jpg\n" + (i % 2 ? "10 10 -1 20 20 4\n" : "\n");
    writeText(root / "sparse/0/cameras.txt", "# cameras\n1 " + camera + "\n");
    writeText(root / "sparse/0/images.txt", images);
}

TEST(ColmapScan, framesMasksAndADefaultSplit) {
    TemporaryFolder folder;
    writeModel(folder.path, "SIMPLE_RADIAL 96 128 100 48 64 -0.05");
    auto scan = readScan(folder.path);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->source, ScanSource::Colmap);
    EXPECT_FALSE(scan->metricWorld);
    ASSERT_EQ(scan->frames.size(), 12u);
    EXPECT_EQ(scan->frames[5].split, Split::Test);
    EXPECT_EQ(scan->frames[0].name, "full_100");
    EXPECT_FALSE(scan->frames[0].maskPath.empty());
    EXPECT_DOUBLE_EQ(scan->frames[0].lens.k1, -0.05);
    EXPECT_TRUE(readFrameImage(scan->frames[0]));
}

TEST(ColmapScan, fisheyeIsRefusedWithTheRemedy) {
    TemporaryFolder folder;
    writeModel(folder.path, "OPENCV_FISHEYE 96 128 100 100 48 64 0 0 0 0");
    auto scan = readScan(folder.path);
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"cameras.txt", "OPENCV_FISHEYE", "image_undistorter"}));
}

TEST(ColmapScan, imageNamesCannotLeaveTheFolder) {
    TemporaryFolder folder;
    writeModel(folder.path, "PINHOLE 96 128 100 100 48 64");
    writeText(folder.path / "sparse/0/images.txt", "1 1 0 0 0 0 0 3 1 ../scan.json\n\n");
    auto scan = readScan(folder.path);
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"not allowed"}));
}

}  // namespace
}  // namespace dpl
