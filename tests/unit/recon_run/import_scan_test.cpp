// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/import_scan.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_import/made_captures.h"

namespace dpl::test {
namespace {

namespace fs = std::filesystem;

class ImportScans : public testing::Test {
protected:
    ImportScans() {
        for (int i = 0; i < 3; ++i) addPhoto(i);
    }
    void addPhoto(int i) const { writeBytes(folder_.path / formatText("photos/{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel))); }
    Result<fs::path> import(const fs::path& source) const {
        ReconstructOptions options;
        options.scan = source, options.out = out_;
        fs::create_directories(out_);
        Progress progress(Progress::Style::Quiet);
        return scanToReconstruct(options, progress);
    }
    const TemporaryFolder folder_;
    const fs::path photos_ = folder_.path / "photos", out_ = folder_.path / "out", scan_ = out_ / "scan";
};

TEST_F(ImportScans, aSecondRunTakesTheScanOfTheFirst) {
    ASSERT_TRUE(import(photos_));
    const auto written = fs::last_write_time(scan_ / "scan.json");
    const auto again = import(photos_);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(*again, scan_);
    EXPECT_EQ(fs::last_write_time(scan_ / "scan.json"), written);
}

TEST_F(ImportScans, whatSomebodyElsePutThereIsKept) {
    writeBytes(scan_ / "notes.txt", {1, 2, 3});
    const auto refused = import(photos_);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("move it away"), std::string::npos) << refused.error().message;
    EXPECT_TRUE(fs::exists(scan_ / "notes.txt"));
}

TEST_F(ImportScans, aCaptureAtThePlaceOfItsOwnImportIsKept) {
    fs::create_directories(out_);
    fs::rename(photos_, scan_);
    const auto refused = import(scan_);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("choose another output"), std::string::npos) << refused.error().message;
    EXPECT_TRUE(fs::exists(scan_ / "2.jpg"));
}

TEST_F(ImportScans, whatLiesBesideTheFilesThatAreReadDoesNotMatter) {
    ASSERT_TRUE(import(photos_));
    const auto written = fs::last_write_time(scan_ / "scan.json");
    writeBytes(photos_ / "notes.txt", {1, 2, 3});
    writeBytes(photos_ / "deeper/4.jpg", {1, 2, 3});
    ASSERT_TRUE(import(photos_));
    EXPECT_EQ(fs::last_write_time(scan_ / "scan.json"), written);
    EXPECT_FALSE(fs::exists(out_ / "scan.replaced"));
}

TEST_F(ImportScans, videosWhereTheImportWritesAreRefusedAndStay) {
    ASSERT_TRUE(import(photos_));
    const fs::path walk = scan_ / "walk.mp4";
    writeBytes(walk, {1, 2, 3});
    ReconstructOptions options;
    options.out = out_;
    options.videos.still = {walk};
    Progress progress(Progress::Style::Quiet);
    const auto refused = scanToReconstruct(options, progress);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("walk.mp4 lies in"), std::string::npos) << refused.error().message;
    EXPECT_TRUE(fs::exists(walk));
    EXPECT_FALSE(fs::exists(out_ / "scan.replaced"));
}

TEST_F(ImportScans, aMissingVideoMovesNothing) {
    ASSERT_TRUE(import(photos_));
    ReconstructOptions options;
    options.out = out_;
    options.videos.still = {photos_ / "none.mp4"};
    Progress progress(Progress::Style::Quiet);
    const auto refused = scanToReconstruct(options, progress);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::NotFound);
    EXPECT_TRUE(fs::exists(scan_ / "scan.json"));
    EXPECT_FALSE(fs::exists(out_ / "scan.replaced"));
}

TEST_F(ImportScans, aScanOneFolderDeeperIsTakenAsItIs) {
    ASSERT_TRUE(import(photos_));
    const auto found = import(out_);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(*found, scan_);
}

TEST_F(ImportScans, masksThatWereAddedOutliveAnImportOfMorePhotos) {
    ASSERT_TRUE(import(photos_));
    writeBytes(scan_ / "masks/0.png", {1, 2, 3});
    addPhoto(3);
    const auto again = import(photos_);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_FALSE(fs::exists(scan_ / "masks/0.png"));
    EXPECT_TRUE(fs::exists(out_ / "scan.replaced/masks/0.png"));
}

TEST_F(ImportScans, aDamagedImportIsMadeAgain) {
    ASSERT_TRUE(import(photos_));
    writeBytes(scan_ / "scan.json", {'{'});
    const auto again = import(photos_);
    ASSERT_TRUE(again) << again.error().message;
    auto scan = readScan(scan_, ScanCameras::MayLack);
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_FALSE(scan->frames.empty());
    fs::remove(scan->frames[0].imagePath);
    ASSERT_TRUE(import(photos_));
    EXPECT_TRUE(fs::exists(scan->frames[0].imagePath)) << "a lost picture too";
}

}  // namespace
}  // namespace dpl::test
