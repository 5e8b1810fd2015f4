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

namespace fs = std::filesystem;

/** A model of pictures `first` … `last` − 1 of the builder's. between: after each image's line. */
void writeImages(const fs::path& model, int first, int last, const char* between = "\n", const char* prefix = "full_") {
    std::string images;
    for (int i = first; i < last; ++i) images += formatText("{} 1 0 0 0 {} 0 3 1 {}{}.jpg\n{}", i + 1, i, prefix, 100 + i, between);
    writeText(model / "cameras.txt", "1 PINHOLE 96 128 100 100 48 64\n");
    writeText(model / "images.txt", images);
}

Scan mustRead(const fs::path& given) {
    auto scan = readScan(given);
    if (!scan) throw std::runtime_error(scan.error().message);
    return *scan;
}

TEST(ColmapScan, theLargestModelIsTakenAndTheOthersAreNamed) {
    TemporaryFolder folder;
    ScanBuilder(folder.path, 12);
    writeImages(folder.path / "sparse/0", 0, 2);
    writeImages(folder.path / "sparse/1", 2, 9);
    writeImages(folder.path / "sparse/10", 9, 12);
    for (const fs::path& given : {folder.path, folder.path / "sparse"}) {
        const Scan scan = mustRead(given);
        ASSERT_EQ(scan.frames.size(), 7u);
        EXPECT_EQ(scan.frames[0].name, "full_102");
        EXPECT_TRUE(
            mentions(scan.assumed, {"of 3 COLMAP models sparse/1 (7 images) is taken", "sparse/10 (3 images)", "sparse/0 (2 images)"}));
    }
    const Scan chosen = mustRead(folder.path / "sparse/0");
    EXPECT_EQ(chosen.frames.size(), 2u);
    EXPECT_EQ(chosen.assumed, "");
    // Equal models: the first, as before. One that is damaged is not the largest.
    writeImages(folder.path / "sparse/0", 0, 7);
    EXPECT_EQ(mustRead(folder.path).frames[0].name, "full_100");
    writeText(folder.path / "sparse/0/images.txt", "damaged\n");
    EXPECT_EQ(mustRead(folder.path).frames[0].name, "full_102");
}

TEST(ColmapScan, everyFolderThatProgramsOfColmapWrite) {
    for (const char* model : {"sparse/0", "sparse", "colmap/sparse/0", "."}) {
        TemporaryFolder folder;
        ScanBuilder(folder.path, 12);
        writeImages(folder.path / model, 0, 12);
        for (const fs::path& given : {folder.path, (folder.path / model).lexically_normal()}) {
            const Scan scan = mustRead(given);
            EXPECT_EQ(scan.frames.size(), 12u) << given;
            EXPECT_FALSE(scan.frames[0].maskPath.empty()) << given;
        }
    }
    for (const char* dense : {"dense/0", "dense", "0"}) {
        TemporaryFolder folder;
        ScanBuilder(folder.path / dense, 12);
        writeImages(folder.path / dense / "sparse", 0, 12);
        for (const fs::path& given : {folder.path, folder.path / dense, folder.path / dense / "sparse"})
            EXPECT_EQ(mustRead(given).frames.size(), 12u) << given;
        writeImages(folder.path / "sparse/0", 0, 12);  // before its pictures were undistorted: they lie elsewhere
        EXPECT_EQ(mustRead(folder.path).frames.size(), 12u);
    }
    TemporaryFolder folder;
    for (int i : {0, 1}) {
        ScanBuilder(folder.path / formatText("dense/{}", i), 12);
        writeImages(folder.path / formatText("dense/{}/sparse", i), 0, 4 + 8 * i);
    }
    const Scan scan = mustRead(folder.path);
    EXPECT_EQ(scan.frames.size(), 12u);
    EXPECT_TRUE(mentions(scan.assumed, {"dense/1/sparse (12 images) is taken", "dense/0/sparse (4 images)"}));
}

TEST(ColmapScan, linesOfPointsMayBeMissing) {
    for (const char* between : {"", "\n", "10 10 -1 20 20 4\n", "1 2 3\n# a comment\n", "  \n\n"}) {
        TemporaryFolder folder;
        ScanBuilder(folder.path, 12);
        writeImages(folder.path / "sparse/0", 0, 12, between);
        const Scan scan = mustRead(folder.path);
        ASSERT_EQ(scan.frames.size(), 12u) << between;
        for (int i = 0; i < 12; ++i) EXPECT_EQ(scan.frames[size_t(i)].camera.viewFromWorldTranslation.x, i);
    }
    TemporaryFolder folder;
    ScanBuilder(folder.path, 12);
    writeImages(folder.path / "sparse/0", 0, 12, "10 10\n");  // neither points nor an image
    EXPECT_FALSE(readScan(folder.path));
}

TEST(ColmapScan, picturesThatCannotBeReadAreLeftOutByName) {
    TemporaryFolder folder;
    ScanBuilder(folder.path, 12);
    writeImages(folder.path / "sparse/0", 0, 12);
    fs::remove(folder.path / "images/full_103.jpg");
    writeText(folder.path / "images/full_105.jpg", "");
    cv::imwrite((folder.path / "images/full_107.jpg").string(), cv::Mat::zeros(64, 48 * 3, CV_8UC3));
    const Scan scan = mustRead(folder.path);
    EXPECT_EQ(scan.frames.size(), 9u);
    EXPECT_TRUE(
        mentions(scan.assumed, {"3 of 12 pictures are left out: full_103.jpg, full_105.jpg, full_107.jpg", "full_103.jpg is missing"}));
    fs::remove_all(folder.path / "images");
    fs::create_directories(folder.path / "images");
    const auto none = readScan(folder.path);
    ASSERT_FALSE(none);
    EXPECT_TRUE(mentions(none.error().message, {"full_100.jpg is missing"}));
}

TEST(ColmapScan, picturesWithDamagedPixelsAreLeftOutByName) {
    TemporaryFolder folder;
    ScanBuilder(folder.path, 12);
    writeImages(folder.path / "sparse/0", 0, 12);
    damagePixels(folder.path / "images/full_104.jpg");
    damagePixels(folder.path / "masks/full_106.png");
    const Scan scan = mustRead(folder.path);
    EXPECT_EQ(scan.frames.size(), 10u);
    EXPECT_TRUE(mentions(scan.assumed, {"2 of 12 pictures are left out: full_104.jpg, full_106.jpg", "damaged JPEG"}));
}

/** A lens that is not read counts only for the images that use it. */
TEST(ColmapScan, imagesOfALensThatIsNotReadAreLeftOutByName) {
    TemporaryFolder folder;
    ScanBuilder(folder.path, 12);
    writeImages(folder.path / "sparse/0", 0, 12);
    const fs::path cameras = folder.path / "sparse/0/cameras.txt", images = folder.path / "sparse/0/images.txt";
    for (const char* other :
         {"2 OPENCV_FISHEYE 96 128 100 100 48 64 0 0 0 0\n", "2 OF_TOMORROW 1 2 3\n", "2 PINHOLE 96 128 0 100 48 64\n"}) {
        SCOPED_TRACE(other);
        writeText(cameras, std::string(other) + "1 PINHOLE 96 128 100 100 48 64\n");
        const Scan unused = mustRead(folder.path);
        EXPECT_EQ(unused.frames.size(), 12u);
        EXPECT_EQ(unused.assumed.find("left out"), std::string::npos) << "no image uses it: " << unused.assumed;
    }
    writeText(cameras, "1 PINHOLE 96 128 100 100 48 64\n2 OPENCV_FISHEYE 96 128 100 100 48 64 0 0 0 0\n3 PINHOLE 96 128 0 100 48 64\n");
    std::string text;
    for (int i = 0; i < 12; ++i)
        text += formatText("{} 1 0 0 0 {} 0 3 {} full_{}.jpg\n\n", i + 1, i, i == 2 || i == 5 ? 2 : i == 7 ? 3 : i == 8 ? 9 : 1, 100 + i);
    writeText(images, text);
    const Scan scan = mustRead(folder.path);
    EXPECT_EQ(scan.frames.size(), 8u);
    EXPECT_TRUE(mentions(scan.assumed, {"4 of 12 pictures are left out: full_102.jpg, full_105.jpg, full_107.jpg, full_108.jpg",
                                        "cameras.txt camera 2", "OPENCV_FISHEYE", "image_undistorter"}));
}

TEST(ColmapScan, namesOfAnyScriptAndEqualNames) {
    TemporaryFolder folder;
    ScanBuilder(folder.path, 12);
    const char* const names[] = {"一.jpg", "丁.jpg", "Ümläut é.jpg", "a b.jpg", "a_b.jpg", "a?b.jpg", "sub/a_b.jpg", "c.jpg", "c.png"};
    std::string images;
    for (size_t i = 0; i < std::size(names); ++i) {
        fs::create_directories((folder.path / "images" / names[i]).parent_path());
        fs::copy_file(folder.path / "images/full_100.jpg", folder.path / "images" / names[i]);
        images += formatText("{} 1 0 0 0 0 0 3 1 {}\n\n", i + 1, names[i]);
    }
    writeText(folder.path / "sparse/0/cameras.txt", "1 PINHOLE 96 128 100 100 48 64\n");
    writeText(folder.path / "sparse/0/images.txt", images);
    const Scan scan = mustRead(folder.path);
    std::vector<std::string> found;
    for (const ScanFrame& frame : scan.frames) found.push_back(frame.name);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, (std::vector<std::string>{"a_b", "a_b_2", "a_b_3", "c", "c_2", "sub_a_b", "Ümläut_é", "一", "丁"}));
}

}  // namespace
}  // namespace dpl
