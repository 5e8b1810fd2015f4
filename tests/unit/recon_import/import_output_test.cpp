// SPDX-License-Identifier: Apache-2.0
// Where an import writes: to the end of a link, and one import at a time.
#include "reconstruction/input/import/import.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_import/made_captures.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

std::string errorOf(const Result<ImportReport>& done) {
    return done ? "was imported" : done.error().message;
}

class ImportOutput : public testing::Test {
protected:
    ImportOutput() {
        for (int i = 0; i < 3; ++i) writeBytes(root_ / formatText("photos/{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel)));
    }
    Result<ImportReport> import(const ImportProgress& progress = {}) const {
        ImportOptions options;
        options.source = root_ / "photos", options.out = root_ / "scan";
        return importCapture(options, nullptr, progress);
    }
    const TemporaryFolder folder_;
    const fs::path root_ = folder_.path;
};

TEST_F(ImportOutput, aLinkStaysAndItsTargetIsWritten) {
    fs::create_directories(root_ / "disk/empty");
    fs::create_directory_symlink("disk/empty", root_ / "scan");
    const auto done = import();
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(fs::is_symlink(root_ / "scan"));
    EXPECT_TRUE(fs::exists(root_ / "disk/empty/scan.json"));
    EXPECT_EQ(must(readScan(root_ / "scan", ScanCameras::MayLack)).name, "scan");
    for (const char* left : {"scan.partial", "disk/empty.partial"}) EXPECT_FALSE(fs::exists(root_ / left)) << left;
}

TEST_F(ImportOutput, aLinkToNothingYetIsFollowed) {
    fs::create_directory_symlink(root_ / "disk/new", root_ / "scan");
    const auto done = import();
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(fs::is_symlink(root_ / "scan"));
    EXPECT_TRUE(fs::exists(root_ / "disk/new/scan.json"));
}

TEST_F(ImportOutput, aFileAtItsPlaceIsKeptAndNamed) {
    writeText(root_ / "scan", "x");
    EXPECT_TRUE(mentions(errorOf(import()), {"scan is a file"}));
}

TEST_F(ImportOutput, namedVideosAreCheckedBeforeOneIsDecoded) {
    const auto refusal = [&](std::vector<fs::path> still, std::vector<fs::path> closeup) {
        ImportOptions options;
        options.videos.still = std::move(still), options.videos.closeup = std::move(closeup), options.out = root_ / "scan";
        return errorOf(importCapture(options, nullptr, {}));
    };
    const fs::path video = root_ / "a.mp4";
    writeText(video, "not decoded");
    EXPECT_TRUE(mentions(refusal({video}, {root_ / "none.mp4"}), {"none.mp4: no such video"}));
    EXPECT_TRUE(mentions(refusal({video}, {root_ / "photos/../a.mp4"}), {"a.mp4 is given twice", "--static", "--closeup"}));
    EXPECT_TRUE(mentions(refusal({video}, {root_ / "photos/1.jpg"}),
                         {"1.jpg is a photo", "--closeup takes videos", ("doppel import " + (root_ / "photos").string()).c_str()}));
}

TEST_F(ImportOutput, aSecondImportIsRefusedAndTheFirstOneEnds) {
    std::string second;
    const auto first = import([&](double, const std::string&) {
        if (second.empty()) {
            const auto done = import();
            second = done ? "was imported" : done.error().message;
        }
        return true;
    });
    EXPECT_TRUE(mentions(second, {"another run uses", (root_ / "scan since 20").c_str(), "process"}));
    ASSERT_TRUE(first) << first.error().message;
    EXPECT_FALSE(fs::exists(root_ / "scan/run.lock"));
    EXPECT_FALSE(fs::exists(root_ / "scan.partial"));
}

TEST_F(ImportOutput, whatAKilledImportLeftIsReplaced) {
    writeText(root_ / "scan.partial/run.lock", "since 2026 (process 1)");
    writeText(root_ / "scan.partial/scan/images/old.jpg", "x");
    const auto done = import();
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_FALSE(fs::exists(root_ / "scan/images/old.jpg"));
    EXPECT_FALSE(fs::exists(root_ / "scan.partial"));
}

TEST_F(ImportOutput, aForeignFolderAtThePlaceOfTheWorkIsKept) {
    writeText(root_ / "scan.partial/notes.txt", "x");
    const auto refused = import();
    ASSERT_FALSE(refused);
    EXPECT_TRUE(mentions(refused.error().message, {"scan.partial", "move it away"}));
    EXPECT_FALSE(fs::exists(root_ / "scan.partial/run.lock"));
    EXPECT_TRUE(fs::exists(root_ / "scan.partial/notes.txt"));
}

}  // namespace
}  // namespace dpl
