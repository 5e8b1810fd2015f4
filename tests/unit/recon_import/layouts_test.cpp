// SPDX-License-Identifier: Apache-2.0
// Every layout is recognised and becomes a scan folder whose camera sees a known point where the picture shows it.
#include "reconstruction/input/import/layout.h"

#include "reconstruction/input/import/import.h"
#include "tests/unit/made_zip.h"
#include "tests/unit/recon_import/made_captures.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Result<Scan> importedScan(const fs::path& source, const fs::path& out, std::string* summary = nullptr) {
    ImportOptions options;
    options.source = source;
    options.out = out;
    auto done = importCapture(options, nullptr, {});
    if (!done) return done.error();
    if (summary) *summary = done->summary;
    return readScan(out, ScanCameras::MayLack);
}

void expectMadeScan(const fs::path& source, const fs::path& out, size_t frames, const char* what) {
    std::string summary;
    auto scan = importedScan(source, out, &summary);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_TRUE(mentions(summary, {what}));
    ASSERT_EQ(scan->frames.size(), frames);
    for (const ScanFrame& frame : scan->frames) EXPECT_TRUE(seesMadePoint(frame)) << frame.name;
    EXPECT_FALSE(fs::exists(out.string() + ".partial"));
}

void writePolycam(const fs::path& root, const char* prefix = "") {
    for (int i = 1; i <= 3; ++i) {
        writeBytes(root / (formatText("keyframes/{}images/{}.jpg", prefix, i)), jpegOf(spotPicture(128, 96, kMadeSensorPixel)));
        writeText(root / (formatText("keyframes/{}cameras/{}.json", prefix, i)), polycamKeyframe().dump());
    }
}

/** Writes a Polycam capture, to be imported into folder/scan. */
ImportOptions polycamImport(const TemporaryFolder& folder) {
    writePolycam(folder.path / "poly");
    ImportOptions options;
    options.source = folder.path / "poly", options.out = folder.path / "scan";
    return options;
}

TEST(Layouts, polycamIsTurnedUpright) {
    TemporaryFolder folder;
    writePolycam(folder.path / "poly");
    expectMadeScan(folder.path / "poly", folder.path / "scan", 3, "uncorrected");
    expectMadeScan(folder.path / "poly/keyframes", folder.path / "scan2", 3, "uncorrected");
    writePolycam(folder.path / "poly", "corrected_");
    expectMadeScan(folder.path / "poly", folder.path / "scan3", 3, "corrected by Polycam");
}

TEST(Layouts, polycamPicturesOfAnotherSizeScaleTheCamera) {
    TemporaryFolder folder;
    writePolycam(folder.path / "poly");
    json half = polycamKeyframe();
    for (const char* key : {"fx", "fy", "cx", "cy"}) half[key] = half[key].get<double>() / 2;
    half["width"] = 64, half["height"] = 48;
    for (int i = 1; i <= 3; ++i) writeText(folder.path / formatText("poly/keyframes/cameras/{}.json", i), half.dump());
    expectMadeScan(folder.path / "poly", folder.path / "scan", 3, "Polycam");
}

/** Rewrites the camera files of a capture of writePolycam(). */
void writeKeyframes(const fs::path& root, const json& keyframe, const char* prefix = "") {
    for (int i = 1; i <= 3; ++i) writeText(root / (formatText("keyframes/{}cameras/{}.json", prefix, i)), keyframe.dump());
}

TEST(Layouts, polycamWithoutSizesTakesThoseOfThePictures) {
    TemporaryFolder folder;
    json keyframe = polycamKeyframe();
    keyframe.erase("width");
    writePolycam(folder.path / "poly");
    writeKeyframes(folder.path / "poly", keyframe);
    expectMadeScan(folder.path / "poly", folder.path / "one side", 3, "uncorrected");
    keyframe.erase("height");
    writeKeyframes(folder.path / "poly", keyframe);
    expectMadeScan(folder.path / "poly", folder.path / "none", 3, "uncorrected");
    writePolycam(folder.path / "poly", "corrected_");  // as Polycam's app writes it: sizes beside the raw pictures alone
    writeKeyframes(folder.path / "poly", polycamKeyframe());
    writeKeyframes(folder.path / "poly", keyframe, "corrected_");
    expectMadeScan(folder.path / "poly", folder.path / "corrected", 3, "corrected by Polycam");
}

TEST(Layouts, polycamOfThePresentAppIsRead) {
    const auto data = sharedData("faults/polycam-nosize/keyframes/corrected_cameras/100000000000.json");
    if (!data) GTEST_SKIP() << "shared data (faults/polycam-nosize) is not on this machine";
    TemporaryFolder folder;
    const auto scan = importedScan(data->parent_path().parent_path(), folder.path / "scan");
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_EQ(scan->frames.size(), 9u);
    EXPECT_EQ(scan->frames[0].camera.widthPx, 96u);
    EXPECT_NEAR(scan->frames[0].camera.fx, 96.148034691, 1e-9);
}

TEST(Layouts, record3dWithoutASizeTakesThatOfItsFirstPicture) {
    TemporaryFolder folder;
    json metadata = record3dMetadata(3);
    metadata.erase("w");
    metadata.erase("h");
    writeText(folder.path / "rec/metadata.json", metadata.dump());
    for (int i = 0; i < 3; ++i) writeBytes(folder.path / formatText("rec/rgb/{}.jpg", i), jpegOf(spotPicture(128, 96, kMadeSensorPixel)));
    expectMadeScan(folder.path / "rec", folder.path / "scan", 3, "Record3D");
}

TEST(Layouts, record3dFolderAndFileAgree) {
    TemporaryFolder folder;
    const auto jpeg = jpegOf(spotPicture(128, 96, kMadeSensorPixel));
    writeText(folder.path / "rec/metadata.json", record3dMetadata(4).dump());
    for (int i = 0; i < 4; ++i) writeBytes(folder.path / formatText("rec/rgb/{}.jpg", i), jpeg);
    expectMadeScan(folder.path / "rec", folder.path / "scan", 4, "Record3D");

    const std::string metadata = record3dMetadata(4).dump();
    std::vector<std::pair<std::string, std::vector<uint8_t>>> entries = {{"metadata", {metadata.begin(), metadata.end()}},
                                                                         {"rgbd/../../../escape.jpg", jpeg}};
    for (int i = 0; i < 4; ++i) entries.push_back({formatText("rgbd/{}.jpg", i), jpeg});
    writeBytes(folder.path / "rec.r3d", zip(entries));
    expectMadeScan(folder.path / "rec.r3d", folder.path / "scan2", 4, "Record3D");
    EXPECT_FALSE(fs::exists(folder.path / "escape.jpg"));
}

TEST(Layouts, record3dIntrinsicsOfEachFrameWin) {
    TemporaryFolder folder;
    json metadata = record3dMetadata(3);
    metadata["K"][0] = 50.0, metadata["K"][4] = 50.0;
    metadata["perFrameIntrinsicCoeffs"] = json::array();
    for (int i = 0; i < 3; ++i) metadata["perFrameIntrinsicCoeffs"].push_back({100.0, 100.0, 64.0, 48.0});
    writeText(folder.path / "rec/metadata.json", metadata.dump());
    for (int i = 0; i < 3; ++i) writeBytes(folder.path / formatText("rec/rgb/{}.jpg", i), jpegOf(spotPicture(128, 96, kMadeSensorPixel)));
    expectMadeScan(folder.path / "rec", folder.path / "scan", 3, "Record3D");
}

TEST(Layouts, nerfCaptureHasIntrinsicsForEachFrame) {
    TemporaryFolder folder;
    json frames = json::array();
    for (int i = 0; i < 3; ++i) {
        writeBytes(folder.path / formatText("cap/images/{}.png", i), pngOf(spotPicture(128, 96, kMadeSensorPixel)));
        frames.push_back({{"file_path", formatText("images/{}", i)},
                          {"timestamp", 0.5 * i},
                          {"fl_x", 100.0},
                          {"fl_y", 100.0},
                          {"cx", 64.0},
                          {"cy", 48.0},
                          {"w", 128},
                          {"h", 96},
                          {"transform_matrix", {{0, 1, 0, 0}, {-1, 0, 0, 1}, {0, 0, 1, 3}, {0, 0, 0, 1}}}});
    }
    writeText(folder.path / "cap/transforms.json", json{{"depth_integer_scale", 1.0}, {"frames", frames}}.dump());
    expectMadeScan(folder.path / "cap", folder.path / "scan", 3, "written by NeRFCapture, so its world is in metres");
}

TEST(Layouts, aForeignWorldIsOfUnknownScaleUnlessItStatesMetres) {
    TemporaryFolder folder;
    json manifest = {{"fl_x", 100.0}, {"frames", json::array()}};
    for (int i = 0; i < 3; ++i) {
        writeBytes(folder.path / formatText("zup/images/{}.png", i), pngOf(spotPicture(96, 128, kMadePixel)));
        manifest["frames"].push_back({{"file_path", formatText("images/{}.png", i)},
                                      {"transform_matrix", {{1, 0, 0, 0}, {0, 0, -1, -3}, {0, 1, 0, 1}, {0, 0, 0, 1}}}});
    }
    std::string summary;
    writeText(folder.path / "zup/transforms.json", manifest.dump());
    auto scan = importedScan(folder.path / "zup", folder.path / "scan", &summary);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_FALSE(scan->metricWorld || scan->unitStated) << "the scan folder says no more than the capture";
    EXPECT_TRUE(mentions(summary, {"cameras of unknown scale", "does not say that its world is in metres", "\"world_up\""}));
    manifest["metric"] = true, manifest["world_up"] = "z";
    writeText(folder.path / "zup/transforms.json", manifest.dump());
    expectMadeScan(folder.path / "zup", folder.path / "scan2", 3, "cameras in metres");
    EXPECT_TRUE(readScan(folder.path / "scan2")->metricWorld);
    manifest["fl_x"] = 200.0, manifest["w"] = 192, manifest["h"] = 256;
    writeText(folder.path / "zup/transforms.json", manifest.dump());
    expectMadeScan(folder.path / "zup", folder.path / "scan3", 3, "3 of 3 pictures have another size than their camera states");
    manifest["w"] = 256, manifest["h"] = 192;
    writeText(folder.path / "zup/transforms.json", manifest.dump());
    scan = importedScan(folder.path / "zup", folder.path / "scan4");
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"96 x 128", "256 x 192", "another shape"}));
}

TEST(Layouts, nerfSyntheticTakesMasksFromAlphaAndSplitsFromFiles) {
    TemporaryFolder folder;
    const double angleX = 2 * std::atan(0.48);
    for (const char* part : {"train", "test"}) {
        json frames = json::array();
        for (int i = 0; i < 3; ++i) {
            writeBytes(folder.path / formatText("lego/{}/r_{}.png", part, i), pngOf(spotPicture(96, 128, kMadePixel, 4)));
            // Blender's world: z up, so the camera at (0, 1, 3) lies at (0, −3, 1) and its back is −y.
            frames.push_back({{"file_path", formatText("./{}/r_{}", part, i)},
                              {"transform_matrix", {{1, 0, 0, 0}, {0, 0, -1, -3}, {0, 1, 0, 1}, {0, 0, 0, 1}}}});
        }
        writeText(folder.path / formatText("lego/transforms_{}.json", part), json{{"camera_angle_x", angleX}, {"frames", frames}}.dump());
    }
    expectMadeScan(folder.path / "lego", folder.path / "scan", 6, "NeRF-synthetic");
    auto scan = readScan(folder.path / "scan");
    ASSERT_TRUE(scan);
    EXPECT_FALSE(scan->metricWorld);
    EXPECT_EQ(std::count_if(scan->frames.begin(), scan->frames.end(), [](const ScanFrame& f) { return f.split == Split::Test; }), 3);
    const auto mask = readFrameMask(scan->frames[0]);
    ASSERT_TRUE(mask) << mask.error().message;
    EXPECT_EQ(mask->pixels[size_t(kMadePixel.y) * 96 + size_t(kMadePixel.x)], 255);
    EXPECT_EQ(mask->pixels[0], 0);
    const auto image = readFrameImage(scan->frames[0]);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->pixels[0], 128);  // grey where it is transparent
}

TEST(Layouts, colmapIsFoundFromFolderSparseAndModel) {
    TemporaryFolder folder;
    const fs::path root = folder.path / "colmap";
    for (int i = 0; i < 3; ++i) writeBytes(root / formatText("images/{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel)));
    writeText(root / "sparse/0/cameras.txt", "1 PINHOLE 96 128 100 100 48 64\n");
    std::string images;
    for (int i = 0; i < 3; ++i) images += formatText("{} 0 1 0 0 0 1 3 1 {}.jpg\n\n", i + 1, i);  // a turn about x by 180°
    writeText(root / "sparse/0/images.txt", images);
    int made = 0;
    for (const fs::path& given : {root, root / "sparse", root / "sparse/0"}) {
        const auto layout = recogniseCapture(given);
        ASSERT_TRUE(layout) << layout.error().message;
        EXPECT_EQ(layout->kind, CaptureKind::Colmap);
        EXPECT_EQ(layout->root, root);
        expectMadeScan(given, folder.path / formatText("scan{}", made++), 3, "COLMAP");
    }
    EXPECT_FALSE(readScan(folder.path / "scan0")->metricWorld);
    fs::rename(root / "images", root / "input");
    expectMadeScan(root / "sparse/0", folder.path / "scan3", 3, "COLMAP");
    writeText(root / "sparse/0/cameras.txt", "1 PINHOLE 192 256 200 200 96 128\n");
    expectMadeScan(root, folder.path / "scan4", 3, "3 of 3 pictures have another size than their camera states");
}

TEST(Layouts, photosAreTurnedByExifAndStateAFocalLength) {
    TemporaryFolder folder;
    const auto stored = jpegOf(spotPicture(128, 96, kMadeSensorPixel));
    for (int i : {1, 2, 10}) writeBytes(folder.path / formatText("photos/IMG_{}.jpg", i), withExif(stored, 6, 26));
    auto scan = importedScan(folder.path / "photos", folder.path / "scan");
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_FALSE(scan->camerasKnown);
    EXPECT_NEAR(scan->focalGuessPx, 26 * 160 / std::hypot(36.0, 24.0), 1e-9);  // 160 px is the diagonal
    ASSERT_EQ(scan->frames.size(), 3u);
    for (const ScanFrame& frame : scan->frames) {
        const auto image = readFrameImage(frame);
        ASSERT_TRUE(image) << image.error().message;
        ASSERT_EQ(image->widthPx, 96u);
        EXPECT_LT(glm::length(spotIn(*image) - kMadePixel), 0.2) << frame.name;
    }
}

TEST(Layouts, largePhotosAreReducedAndTheirFocalLengthWithThem) {
    TemporaryFolder folder;
    const auto stored = jpegOf(spotPicture(256, 192, 2.0 * kMadeSensorPixel));
    for (int i : {1, 2, 3}) writeBytes(folder.path / formatText("photos/IMG_{}.jpg", i), withExif(stored, 6, 26));
    ImportOptions options;
    options.source = folder.path / "photos", options.out = folder.path / "scan", options.longSidePx = 128;
    const auto summary = importCapture(options, nullptr, {});
    ASSERT_TRUE(summary) << summary.error().message;
    EXPECT_TRUE(mentions(summary->summary, {"3 photos are reduced to 128 pixels"}));
    const auto scan = readScan(options.out, ScanCameras::MayLack);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_NEAR(scan->focalGuessPx, 26 * 160 / std::hypot(36.0, 24.0), 1e-9) << "of the reduced picture, whose diagonal is 160 px";
    for (const ScanFrame& frame : scan->frames) {
        const auto image = readFrameImage(frame);
        ASSERT_TRUE(image) << image.error().message;
        ASSERT_EQ(image->widthPx, 96u);
        ASSERT_EQ(image->heightPx, 128u);
        EXPECT_LT(glm::length(spotIn(*image) - kMadePixel), 0.3) << frame.name;
    }
}

TEST(Layouts, photosOfAnotherSizeAreLeftOutByName) {
    TemporaryFolder folder;
    for (int i = 0; i < 4; ++i) writeBytes(folder.path / formatText("p/{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel)));
    writeBytes(folder.path / "p/9.jpg", jpegOf(spotPicture(64, 64, {32, 32})));
    std::string summary;
    auto scan = importedScan(folder.path / "p", folder.path / "scan", &summary);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames.size(), 4u);
    EXPECT_TRUE(mentions(summary, {"1 of 5 pictures", "96 x 128"}));
    writeBytes(folder.path / "q/close_1.jpg", jpegOf(spotPicture(64, 64, {32, 32})));
    for (int i = 0; i < 4; ++i) writeBytes(folder.path / formatText("q/{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel)));
    auto refused = importedScan(folder.path / "q", folder.path / "scan2");
    ASSERT_FALSE(refused);
    EXPECT_TRUE(mentions(refused.error().message, {"close-ups", "64 x 64", "96 x 128"}));
}

TEST(Layouts, outputsThatExistAndScansAreRefused) {
    TemporaryFolder folder;
    writePolycam(folder.path / "poly");
    writeText(folder.path / "used/file", "x");
    auto used = importedScan(folder.path / "poly", folder.path / "used");
    ASSERT_FALSE(used);
    EXPECT_TRUE(mentions(used.error().message, {"used exists already and is not empty"}));
    ScanBuilder(folder.path / "scan", 2).write();
    auto again = importedScan(folder.path / "scan", folder.path / "out");
    ASSERT_FALSE(again);
    EXPECT_TRUE(mentions(again.error().message, {"scan folder already", "doppel reconstruct", "scan -o OUT"}));
    EXPECT_FALSE(fs::exists(folder.path / "out"));
    EXPECT_FALSE(fs::exists(folder.path / "out.partial"));
}

TEST(Layouts, stoppingLeavesNothing) {
    TemporaryFolder folder;
    const ImportOptions options = polycamImport(folder);
    int calls = 0;
    const auto stopped = importCapture(options, nullptr, [&](double, const std::string&) { return ++calls < 5; });
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Code::Cancelled);
    EXPECT_FALSE(fs::exists(folder.path / "scan"));
    EXPECT_FALSE(fs::exists(folder.path / "scan.partial"));
}

TEST(Layouts, heightIsKeptInTheScan) {
    TemporaryFolder folder;
    ImportOptions options = polycamImport(folder);
    options.heightM = 1.74;
    ASSERT_TRUE(importCapture(options, nullptr, {}));
    EXPECT_EQ(readScan(folder.path / "scan")->subjectHeightM, 1.74);
}

TEST(Layouts, bikerKeepsHisCameras) {
    const auto data = sharedData("real-orbit-biker/transforms.json");
    if (!data) GTEST_SKIP() << "shared data (real-orbit-biker) is not on this machine";
    TemporaryFolder folder;
    const auto before = readScan(data->parent_path());
    const auto after = importedScan(data->parent_path(), folder.path / "scan");
    ASSERT_TRUE(before && after) << after.error().message;
    ASSERT_EQ(after->frames.size(), before->frames.size());
    const Vec3d chest(0.1, 1.3, 0.05);
    for (size_t i = 0; i < after->frames.size(); ++i) {
        const Camerad &a = before->frames[i].camera, &b = after->frames[i].camera;
        EXPECT_LT(glm::length(a.pixelOf(a.toView(chest)) - b.pixelOf(b.toView(chest))), 1e-9);
        EXPECT_EQ(after->frames[i].split, before->frames[i].split);
        EXPECT_FALSE(after->frames[i].maskPath.empty());
    }
}

}  // namespace
}  // namespace dpl
