// SPDX-License-Identifier: Apache-2.0
// What is recognised in a folder or file, and what people are told of the rest.
#include <unistd.h>

#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/import.h"
#include "reconstruction/input/import/layout.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_import/made_captures.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

class Recognise : public testing::Test {
protected:
    /** Why `path` is refused. */
    std::string refusal(const fs::path& path) const {
        const auto layout = recogniseCapture(path);
        return layout ? std::string("recognised as ") + captureName(layout->kind) : layout.error().message;
    }
    void writePhotos(const fs::path& photos, int count = 3) const {
        for (int i = 0; i < count; ++i) writeBytes(photos / formatText("IMG_{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel)));
    }
    /** What the import of `source` says. */
    std::string imported(const fs::path& source) {
        ImportOptions options;
        options.source = source, options.out = folder_.path / formatText("scan-{}", scans_++);
        const auto done = importCapture(options, nullptr, {});
        return done ? done->summary : done.error().message;
    }
    const TemporaryFolder folder_;
    const fs::path root_ = folder_.path;
    int scans_ = 0;
};

TEST_F(Recognise, unknownFoldersSayWhatTheyHoldAndWhatHelps) {
    EXPECT_TRUE(mentions(refusal(root_ / "none"), {"no such file or folder"}));
    fs::create_directories(root_ / "empty");
    EXPECT_TRUE(mentions(refusal(root_ / "empty"), {"neither pictures nor videos", "captures.md"}));
    writeText(root_ / "heic/IMG_1.HEIC", "x");
    EXPECT_TRUE(mentions(refusal(root_ / "heic"), {"1 HEIC", "(IMG_1.HEIC)", "export them as JPEG"}));
    writeText(root_ / "it's $HOME/IMG_1.HEIC", "x");
    EXPECT_TRUE(mentions(refusal(root_ / "it's $HOME"), {("for f in '" + root_.string() + "/it'\\''s $HOME'/*.").c_str()}));
    writeText(root_ / "webp/1.webp", "x");
    EXPECT_TRUE(mentions(refusal(root_ / "webp"), {"1 pictures like 1.webp", "convert them to JPEG"}));
    for (const char* name : {"videos/walk.mp4", "videos/moves.mp4"}) writeText(root_ / name, "x");
    EXPECT_TRUE(mentions(refusal(root_ / "videos"), {"2 videos", "--static"}));
    writeText(root_ / "deep/images/1.jpg", "x");
    EXPECT_TRUE(mentions(refusal(root_ / "deep"), {"images holds 1 pictures", "at least 3"}));
    writeText(root_ / "two/1.jpg", "x");
    EXPECT_TRUE(mentions(refusal(root_ / "two"), {"1 pictures", "at least 3"}));
    writeText(root_ / "notes.pdf", "x");
    EXPECT_TRUE(mentions(refusal(root_ / "notes.pdf"), {"notes.pdf", "give a folder, a video"}));
}

TEST_F(Recognise, foldersThatMayNotBeReadSaySo) {
    writePhotos(root_ / "locked/photos");
    fs::permissions(root_ / "locked", fs::perms::none);
    const bool root = geteuid() == 0;  // who may read everything
    if (root) {
        ASSERT_EQ(seteuid(65534), 0);
    }
    const std::string folder = refusal(root_ / "locked"), below = refusal(root_ / "locked/photos");
    if (root) {
        ASSERT_EQ(seteuid(0), 0);
    }
    fs::permissions(root_ / "locked", fs::perms::owner_all);
    EXPECT_TRUE(mentions(folder, {"locked cannot be read", "check the permissions"}));
    EXPECT_TRUE(mentions(below, {"locked/photos cannot be read", "check the permissions"}));
}

TEST_F(Recognise, archivesAreToBeUnpackedFirst) {
    writeText(root_ / "poly $cam.zip", "PK");
    const std::string command = formatText("unzip '{}' -d '{}'", (root_ / "poly $cam.zip").string(), (root_ / "poly $cam").string());
    EXPECT_TRUE(mentions(refusal(root_ / "poly $cam.zip"), {command.c_str()}));
    EXPECT_TRUE(mentions(refusal(root_), {"holds the archive poly $cam.zip", "unzip"}));
    writeText(root_ / "a.tar.gz", "x");
    EXPECT_TRUE(mentions(refusal(root_ / "a.tar.gz"), {"tar -xf"}));
}

TEST_F(Recognise, aSinglePhotoIsAnsweredWithItsFolder) {
    writePhotos(root_ / "photos");
    EXPECT_TRUE(mentions(refusal(root_ / "photos/IMG_1.jpg"), {"one picture", "at least 3", (root_ / "photos").c_str()}));
    writeText(root_ / "photos/IMG_9.HEIC", "x");
    EXPECT_TRUE(mentions(refusal(root_ / "photos/IMG_9.HEIC"), {"one picture"}));
}

TEST_F(Recognise, heicBesidePhotosIsNamedUntilItIsConverted) {
    writePhotos(root_ / "photos");
    writeText(root_ / "photos/IMG_7.HEIC", "x");
    writeText(root_ / "photos/IMG_2.HEIC", "x");  // there as IMG_2.jpg
    EXPECT_TRUE(mentions(imported(root_ / "photos"), {"3 frames", "1 HEIC photos are left out", "(IMG_7.HEIC)", "heif-convert"}));
    writeBytes(root_ / "photos/IMG_7.HEIC.jpg", jpegOf(spotPicture(96, 128, kMadePixel)));
    const std::string said = imported(root_ / "photos");
    EXPECT_TRUE(mentions(said, {"4 frames"}));
    EXPECT_EQ(said.find("HEIC photos"), std::string::npos) << said;
}

TEST_F(Recognise, aVideoAndFoldersBesidePhotosAreNamed) {
    writePhotos(root_ / "photos");
    writeText(root_ / "photos/walk.mov", "x");
    writePhotos(root_ / "photos/faces", 2);
    for (const char* name : {"IMG_1.DNG", "IMG_8.DNG"}) writeText(root_ / "photos" / name, "x");  // the first one is there as IMG_1.jpg
    EXPECT_TRUE(mentions(imported(root_ / "photos"),
                         {"1 pictures are left out, because only JPEG and PNG are read (IMG_8.DNG)", "1 videos beside them are left out",
                          "for a scan of a video", (root_ / "photos/walk.mov").c_str(), "2 pictures in its folder faces are left out"}));
}

TEST_F(Recognise, theOnlyVideoOfAFolderIsTaken) {
    writeText(root_ / "one/walk.mp4", "x");
    writePhotos(root_ / "one", 2);
    const auto layout = recogniseCapture(root_ / "one");
    ASSERT_TRUE(layout) << layout.error().message;
    EXPECT_EQ(layout->kind, CaptureKind::Video);
    EXPECT_EQ(layout->root, root_ / "one/walk.mp4");
    ASSERT_EQ(layout->notes.size(), 2u);
    EXPECT_TRUE(mentions(layout->notes[0], {"walk.mp4"}));
    EXPECT_TRUE(mentions(layout->notes[1], {"2 pictures beside it are left out"}));
}

TEST_F(Recognise, aVideoIsReadAloneAndPhotosWithoutWhatLiesBelow) {
    for (const char* name : {"one/walk.mp4", "one/moves.mp4", "one/notes.txt"}) writeText(root_ / name, "x");
    EXPECT_EQ(filesOf(must(recogniseCapture(root_ / "one/walk.mp4"))), std::vector{root_ / "one/walk.mp4"});
    writePhotos(root_ / "photos");
    writePhotos(root_ / "photos/faces");
    EXPECT_EQ(filesOf(must(recogniseCapture(root_ / "photos"))).size(), 3u);
}

TEST_F(Recognise, theOnlyCaptureInAFolderIsTakenAndNamed) {
    writePhotos(root_ / "given/export");
    writeText(root_ / "given/__MACOSX/._IMG_0.jpg", "x");
    EXPECT_TRUE(mentions(imported(root_ / "given"), {"3 frames", "the capture lies in", (root_ / "given/export").c_str()}));
    writePhotos(root_ / "given/other");
    EXPECT_TRUE(
        mentions(refusal(root_ / "given"), {"2 captures", "export (a folder of photos)", "other (a folder of photos)", "name one"}));
}

TEST_F(Recognise, everyEndingOfAVideoIsKnown) {
    for (const VideoEnding& ending : kVideoEndings) {
        const fs::path file = root_ / ("walk" + std::string(ending.extension));
        writeText(file, "x");
        const auto layout = recogniseCapture(file);
        ASSERT_TRUE(layout) << layout.error().message;
        EXPECT_EQ(layout->kind, CaptureKind::Video);
    }
    EXPECT_EQ(videosIn(root_).size(), std::size(kVideoEndings));
}

TEST(FileNames, digitsInNamesCountAsNumbers) {
    EXPECT_TRUE(naturallyBefore("IMG_2.jpg", "IMG_10.jpg"));
    EXPECT_FALSE(naturallyBefore("IMG_10.jpg", "IMG_2.jpg"));
    EXPECT_TRUE(naturallyBefore("a", "b1"));
    EXPECT_FALSE(naturallyBefore("x01", "x1") == naturallyBefore("x1", "x01"));
}

}  // namespace
}  // namespace dpl
