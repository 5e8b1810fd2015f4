// SPDX-License-Identifier: Apache-2.0
// COLMAP models, text and binary: the same cameras from both, every truncation refused.
#include "reconstruction/input/cameras/colmap_model.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "sdk/core/writer.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

struct Folder {
    fs::path path;
    Folder() {
        path = fs::temp_directory_path() /
               ("dpl_colmap_" + std::to_string(::getpid()) + "_" + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(path);
        fs::create_directories(path);
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    void write(const char* name, const std::string& text) const { std::ofstream(path / name, std::ios::binary) << text; }
    void write(const char* name, const std::vector<uint8_t>& bytes) const { write(name, std::string(bytes.begin(), bytes.end())); }
};

const char* kCamerasText = "# Camera list\n1 OPENCV 640 480 500 501 320 240 -0.1 0.01 0.001 -0.002\n2 SIMPLE_PINHOLE 640 480 510 321 241\n";
const char* kImagesText = "# Image list\n7 0.8 0 0.6 0 0.1 0.2 3 1 b.jpg\n1.5 2.5 -1 3 4 17\n9 1 0 0 0 0 0 2 2 sub dir/a.jpg\n\n";

std::vector<uint8_t> camerasBinary() {
    Writer w;
    w.value(uint64_t(2));
    w.value(uint32_t(1)), w.value(int32_t(4)), w.value(uint64_t(640)), w.value(uint64_t(480));
    for (double v : {500.0, 501.0, 320.0, 240.0, -0.1, 0.01, 0.001, -0.002}) w.value(v);
    w.value(uint32_t(2)), w.value(int32_t(0)), w.value(uint64_t(640)), w.value(uint64_t(480));
    for (double v : {510.0, 321.0, 241.0}) w.value(v);
    return w.finish();
}

void binaryImage(Writer& w, uint32_t id, std::initializer_list<double> pose, uint32_t camera, const std::string& name, uint64_t points) {
    w.value(id);
    for (double v : pose) w.value(v);
    w.value(camera);
    for (char c : name) w.value(c);
    w.value('\0');
    w.value(points);
    for (uint64_t i = 0; i < points; ++i) w.value(1.5), w.value(2.5), w.value(int64_t(-1));
}

std::vector<uint8_t> imagesBinary() {
    Writer w;
    w.value(uint64_t(2));
    binaryImage(w, 7, {0.8, 0, 0.6, 0, 0.1, 0.2, 3}, 1, "b.jpg", 2);
    binaryImage(w, 9, {1, 0, 0, 0, 0, 0, 2}, 2, "sub dir/a.jpg", 0);
    return w.finish();
}

void expectTheTwoImages(const std::vector<ColmapImage>& images) {
    ASSERT_EQ(images.size(), 2u);
    EXPECT_EQ(images[0].name, "b.jpg");
    EXPECT_EQ(images[1].name, "sub dir/a.jpg");
    EXPECT_EQ(images[0].camera.fy, 501);
    EXPECT_EQ(images[0].lens.p2, -0.002);
    EXPECT_EQ(images[1].camera.fy, 510);
    EXPECT_EQ(images[1].camera.cx, 321);
    EXPECT_FALSE(images[1].lens.any());
    // Quaternion (w 0.8, y 0.6): a turn about y with cos = 0.8² − 0.6² = 0.28, sin = 0.96.
    EXPECT_NEAR(images[0].camera.viewFromWorldRotation[0][0], 0.28, 1e-12);
    EXPECT_NEAR(images[0].camera.viewFromWorldRotation[2][0], 0.96, 1e-12);
    EXPECT_EQ(images[0].camera.viewFromWorldTranslation, Vec3d(0.1, 0.2, 3));
}

TEST(ColmapModel, textAndBinaryAgree) {
    Folder folder;
    folder.write("cameras.txt", kCamerasText);
    folder.write("images.txt", kImagesText);
    EXPECT_EQ(findColmapModel(folder.path), folder.path);
    auto text = readColmapModel(folder.path);
    ASSERT_TRUE(text) << text.error().message;
    expectTheTwoImages(*text);
    folder.write("cameras.bin", camerasBinary());
    folder.write("images.bin", imagesBinary());
    auto binary = readColmapModel(folder.path);
    ASSERT_TRUE(binary) << binary.error().message;
    expectTheTwoImages(*binary);
}

TEST(ColmapModel, everyTruncationOfTheBinaryIsRefused) {
    Folder folder;
    const auto cameras = camerasBinary(), images = imagesBinary();
    folder.write("cameras.bin", cameras);
    for (size_t n = 0; n < images.size(); ++n) {
        folder.write("images.bin", std::vector<uint8_t>(images.begin(), images.begin() + n));
        auto read = readColmapModel(folder.path);
        ASSERT_FALSE(read) << n;
        EXPECT_NE(read.error().message.find("images.bin"), std::string::npos) << read.error().message;
    }
    folder.write("images.bin", images);
    for (size_t n = 0; n < cameras.size(); ++n) {
        folder.write("cameras.bin", std::vector<uint8_t>(cameras.begin(), cameras.begin() + n));
        auto read = readColmapModel(folder.path);
        ASSERT_FALSE(read) << n;
        EXPECT_NE(read.error().message.find("cameras.bin"), std::string::npos) << read.error().message;
    }
}

/** Of a lens that is known and not read, the numbers are skipped, in text and in binary; images of it are told apart. */
TEST(ColmapModel, aLensThatIsNotReadConcernsItsImagesAlone) {
    Folder folder;
    Writer w;
    w.value(uint64_t(3));
    w.value(uint32_t(5)), w.value(int32_t(6)), w.value(uint64_t(640)), w.value(uint64_t(480));  // FULL_OPENCV
    for (int k = 0; k < 12; ++k) w.value(0.5 * k);
    w.value(uint32_t(1)), w.value(int32_t(1)), w.value(uint64_t(640)), w.value(uint64_t(480));
    for (double v : {500.0, 501.0, 320.0, 240.0}) w.value(v);
    w.value(uint32_t(2)), w.value(int32_t(11)), w.value(uint64_t(640)), w.value(uint64_t(480));
    for (int k = 0; k < 16; ++k) w.value(0.5 * k);
    folder.write("cameras.bin", w.finish());
    folder.write("cameras.txt", "5 FULL_OPENCV 640 480 1 2 3\n1 PINHOLE 640 480 500 501 320 240\n2 RAD_TAN_THIN_PRISM_FISHEYE 640 480 1\n");
    folder.write("images.txt", kImagesText);
    for (const char* kind : {"text", "binary"}) {
        SCOPED_TRACE(kind);
        if (kind[0] == 'b') folder.write("images.bin", imagesBinary());
        std::vector<UnreadColmapImage> unread;
        auto read = readColmapModel(folder.path, &unread);
        ASSERT_TRUE(read) << read.error().message;
        ASSERT_EQ(read->size(), 1u);
        EXPECT_EQ(read->front().name, "b.jpg");
        EXPECT_EQ(read->front().camera.fy, 501);
        ASSERT_EQ(unread.size(), 1u);
        EXPECT_EQ(unread[0].name, "sub dir/a.jpg");
        EXPECT_EQ(unread[0].why.code, Code::Unsupported);
        EXPECT_NE(unread[0].why.message.find("camera 2: camera model RAD_TAN_THIN_PRISM_FISHEYE"), std::string::npos)
            << unread[0].why.message;
        EXPECT_FALSE(readColmapModel(folder.path)) << "whoever takes no list wants all images";
    }
}

TEST(ColmapModel, lyingCountsDoNotAllocate) {
    Folder folder;
    auto cameras = camerasBinary();
    for (int i = 0; i < 8; ++i) cameras[i] = 0xff;
    folder.write("cameras.bin", cameras);
    folder.write("images.bin", imagesBinary());
    EXPECT_FALSE(readColmapModel(folder.path));
}

TEST(ColmapModel, wrongTextIsRefusedByLine) {
    Folder folder;
    folder.write("images.txt", kImagesText);
    for (const char* bad : {"1 PINHOLE 640 480 500 500 320\n", "1 PINHOLE 640 480 0 500 320 240\n", "x PINHOLE 640 480 500 500 320 240\n",
                            "1 PINHOLE 640 480 nan 500 320 240\n", "1 PINHOLE -640 480 500 500 320 240\n",
                            "1 FULL_OPENCV 640 480 1 1 1 1\n", "1 PINHOLE 640 480 500 500 320 240\n1 PINHOLE 640 480 500 500 320 240\n"}) {
        folder.write("cameras.txt", bad);
        auto read = readColmapModel(folder.path);
        ASSERT_FALSE(read) << bad;
        EXPECT_NE(read.error().message.find("cameras.txt"), std::string::npos) << read.error().message;
    }
    folder.write("cameras.txt", kCamerasText);
    for (const char* bad : {"", "7 0 0 0 0 0 0 3 1 b.jpg\n\n", "7 1 0 0 0 0 0 3 5 b.jpg\n\n", "7 1 0 0 0 0 0 3 1\n\n",
                            "7 1 0 0 nan 0 0 3 1 b.jpg\n\n", "seven\n"}) {
        folder.write("images.txt", bad);
        EXPECT_FALSE(readColmapModel(folder.path)) << bad;
    }
}

}  // namespace
}  // namespace dpl
