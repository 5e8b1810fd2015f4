// SPDX-License-Identifier: Apache-2.0
// Broken scan folders: each is refused with a sentence that names the file or frame and what to do.
#include <functional>

#include "reconstruction/input/capture/scan.h"
#include "tests/unit/recon_capture/scan_builder.h"

namespace dpl {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/** Breaks a good scan of three frames and expects readScan to refuse it with these words. */
void expectRefused(const std::function<void(ScanBuilder&)>& breakIt, std::initializer_list<const char*> words) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 3);
    breakIt(builder);
    auto scan = readScan(builder.write());
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, words));
}

json& frame(ScanBuilder& b) {
    return b.manifest["frames"][1];
}

TEST(HostileScan, missingImage) {
    expectRefused([](ScanBuilder& b) { fs::remove(b.root / "images/full_101.jpg"); }, {"full_101.jpg", "missing", "restore"});
}
TEST(HostileScan, missingMaskThatIsListed) {
    expectRefused([](ScanBuilder& b) { fs::remove(b.root / "masks/full_101.png"); }, {"full_101.png", "missing", "restore"});
}
TEST(HostileScan, imageOfAnotherSize) {
    expectRefused([](ScanBuilder& b) { cv::imwrite((b.root / "images/full_101.jpg").string(), cv::Mat::zeros(64, 48, CV_8UC3)); },
                  {"full_101", "48 x 64", "96 x 128", "resize"});
}
TEST(HostileScan, imageThatIsADirectory) {
    expectRefused([](ScanBuilder& b) { frame(b)["image"] = "images"; }, {"images", "not a file"});
}
TEST(HostileScan, emptyImageFile) {
    expectRefused([](ScanBuilder& b) { writeText(b.root / "images/full_101.jpg", ""); }, {"full_101.jpg", "empty"});
}
TEST(HostileScan, imageOfAnotherFormat) {
    const std::tuple<std::string, const char*, const char*> table[] = {{"GIF89a", "GIF is not read", "ffmpeg -i"},
                                                                       {"BM....", "BMP is not read", "ffmpeg -i"},
                                                                       {"RIFF....WEBPVP8 ", "WebP is not read", "ffmpeg -i"},
                                                                       {std::string("MM\0*", 4), "TIFF is not read", "ffmpeg -i"},
                                                                       {"....ftypavif", "AVIF is not read", "ffmpeg -i"},
                                                                       {"....ftypmif1", "HEIC is not read", "heif-convert -q 95"},
                                                                       {"....ftypqt  ", "neither JPEG nor PNG", "convert the image"}};
    for (const auto& [bytes, what, how] : table)
        expectRefused([&bytes = bytes](ScanBuilder& b) { writeText(b.root / "images/full_101.jpg", bytes + std::string(40, '.')); },
                      {"full_101.jpg", what, how});
}
TEST(HostileScan, zeroFocalLength) {
    expectRefused([](ScanBuilder& b) { frame(b)["camera"]["fx"] = 0; }, {"full_101", "fx", "focal length"});
}
TEST(HostileScan, focalLengthInMillimetres) {
    expectRefused([](ScanBuilder& b) { frame(b)["camera"]["fx"] = 4.2, frame(b)["camera"]["fy"] = 4.2; },
                  {"full_101", "field of view", "pixels"});
}
TEST(HostileScan, absentIntrinsics) {
    expectRefused([](ScanBuilder& b) { frame(b)["camera"].erase("fy"); }, {"full_101", "fy", "missing"});
}
TEST(HostileScan, absentCamera) {
    expectRefused([](ScanBuilder& b) { frame(b).erase("camera"); }, {"full_101", "camera", "register"});
}
TEST(HostileScan, textWhereANumberBelongs) {
    expectRefused([](ScanBuilder& b) { frame(b)["camera"]["cx"] = "nan"; }, {"full_101", "cx", "finite"});
}
TEST(HostileScan, notANumberInTheFile) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 2);
    builder.write();
    for (const char* bad : {R"({"format":"avatar-scan","version":NaN})", R"({"format":"avatar-scan","version":1e999})", "[1,2]", "", "{"}) {
        writeText(folder.path / "scan.json", bad);
        auto scan = readScan(folder.path);
        ASSERT_FALSE(scan) << bad;
        EXPECT_TRUE(mentions(scan.error().message, {"scan.json"}));
    }
}
TEST(HostileScan, mirroredRotation) {
    expectRefused(
        [](ScanBuilder& b) {
            for (int i = 0; i < 3; ++i) frame(b)["camera"]["R"][i] = -frame(b)["camera"]["R"][i].get<double>();
        },
        {"full_101", "mirrors"});
}
TEST(HostileScan, scaledRotation) {
    expectRefused(
        [](ScanBuilder& b) {
            for (auto& v : frame(b)["camera"]["R"]) v = v.get<double>() * 1.01;
        },
        {"full_101", "not a rotation"});
}
TEST(HostileScan, rotationOfEightNumbers) {
    expectRefused([](ScanBuilder& b) { frame(b)["camera"]["R"].erase(8); }, {"full_101", "8 numbers", "9"});
}
TEST(HostileScan, principalPointFarOutside) {
    expectRefused([](ScanBuilder& b) { frame(b)["camera"]["cx"] = 5000; }, {"full_101", "principal point"});
}
TEST(HostileScan, pathsThatLeaveTheFolder) {
    for (const char* path : {"../images/full_100.jpg", "/etc/passwd", "images/../../x.jpg", "", "images\\full_101.jpg"})
        expectRefused([&](ScanBuilder& b) { frame(b)["image"] = path; }, {"not allowed", "relative"});
}
TEST(HostileScan, namesThatStagesCouldNotUseAsFiles) {
    for (const char* name : {"../up", "a/b", "", ".hidden", "sp ace"})
        expectRefused([&](ScanBuilder& b) { frame(b)["name"] = name; }, {"frame name"});
}
TEST(HostileScan, oneNameTwice) {
    expectRefused([](ScanBuilder& b) { frame(b)["name"] = "full_100"; }, {"full_100", "twice"});
}
TEST(HostileScan, oneImageForTwoFrames) {
    expectRefused([](ScanBuilder& b) { frame(b)["image"] = "images/full_100.jpg"; }, {"full_100.jpg", "two frames"});
}
TEST(HostileScan, anotherVersionSaysSo) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 2);
    builder.manifest["version"] = 2;
    auto scan = readScan(builder.write());
    ASSERT_FALSE(scan);
    EXPECT_EQ(scan.error().code, Code::Version);
}
TEST(HostileScan, noFrames) {
    expectRefused([](ScanBuilder& b) { b.manifest["frames"] = json::array(); }, {"no frame"});
}
TEST(HostileScan, hugeManifestIsNotParsed) {
    TemporaryFolder folder;
    writeText(folder.path / "scan.json", "");
    fs::resize_file(folder.path / "scan.json", 100u << 20);
    auto scan = readScan(folder.path);
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"scan.json", "104857600 bytes"}));
}
TEST(HostileScan, deepNestingIsRefused) {
    TemporaryFolder folder;
    writeText(folder.path / "scan.json", "{\"a\":" + std::string(40000, '[') + std::string(40000, ']') + "}");
    auto scan = readScan(folder.path);
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"scan.json", "nested"}));
}
TEST(HostileScan, hugePictureIsRefusedBeforeDecoding) {
    expectRefused(
        [](ScanBuilder& b) {
            std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\0\0\0\1\0\0\x08\2\0\0\0\0\0\0\0", 33);
            writeText(b.root / "images/full_101.jpg", png);
        },
        {"full_101.jpg", "65536 x 65536", "scale"});
}
TEST(HostileScan, emptyFolder) {
    TemporaryFolder folder;
    auto scan = readScan(folder.path);
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"scan.json", "transforms.json", "COLMAP"}));
    EXPECT_FALSE(readScan(folder.path / "not there"));
}

TEST(HostileScan, everyTruncationOfAnImageIsNoticed) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 1);
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_TRUE(readFrameImage(scan->frames[0]));
    ASSERT_TRUE(readFrameMask(scan->frames[0]));
    for (const auto& path : {scan->frames[0].imagePath, scan->frames[0].maskPath}) {
        std::ifstream in(path, std::ios::binary);
        const std::string whole{std::istreambuf_iterator<char>(in), {}};
        for (size_t length = 0; length < whole.size(); length += length < 64 || length + 64 > whole.size() ? 1 : 97) {
            writeText(path, whole.substr(0, length));
            const bool image = path == scan->frames[0].imagePath;
            const auto message = image ? readFrameImage(scan->frames[0]).error().message : readFrameMask(scan->frames[0]).error().message;
            ASSERT_TRUE(mentions(message, {path.filename().c_str()})) << "cut at " << length << " of " << whole.size();
        }
        writeText(path, whole);
    }
}

TEST(HostileScan, flippedBytesInAnImageNeverCrash) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 1);
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    for (const auto& path : {scan->frames[0].imagePath, scan->frames[0].maskPath}) {
        std::ifstream in(path, std::ios::binary);
        const std::string whole{std::istreambuf_iterator<char>(in), {}};
        uint32_t random = 12345;  // fixed seed
        for (int round = 0; round < 200; ++round) {
            std::string bytes = whole;
            random = random * 1664525u + 1013904223u;
            bytes[(random >> 8) % bytes.size()] ^= char(1 << (random & 7));
            writeText(path, bytes);
            if (path == scan->frames[0].imagePath)
                (void)readFrameImage(scan->frames[0]);
            else
                (void)readFrameMask(scan->frames[0]);
        }
        writeText(path, whole);
    }
}

TEST(HostileScan, keypointFilesThatDoNotFit) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 1);
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    for (const char* bad :
         {R"({"detections":[[1,2]]})", R"({"names":["nose","pelvis"],"detections":[[1,2]]})", R"({"names":["nose"],"detections":[[1]]})",
          R"({"names":["nose"],"detections":[["a",2]]})", R"({"names":["nose"],"detections":[[1,2]],"confidence":[]})",
          R"({"names":[7],"detections":[[1,2]]})", R"({"detections":7})", "nonsense"}) {
        writeText(scan->frames[0].keypointsPath, bad);
        auto points = readKeypoints(*scan, scan->frames[0]);
        ASSERT_FALSE(points) << bad;
        EXPECT_TRUE(mentions(points.error().message, {"full_100.json"}));
    }
}

}  // namespace
}  // namespace dpl
