// SPDX-License-Identifier: Apache-2.0
// Good scan folders: axes, splits, optional files, pixels and keypoints.
#include "reconstruction/input/capture/scan.h"

#include <algorithm>

#include "reconstruction/input/capture/hand_keypoints.h"
#include "tests/unit/recon_capture/scan_builder.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

TEST(ScanFolder, readsFramesAndTurnsTheWorldUpright) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 20, 10);
    builder.manifest["frames"][0]["labels"] = "labels.png";
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->name, "tiny");
    ASSERT_EQ(scan->frames.size(), 30u);
    EXPECT_EQ(scan->frames[0].kind, FrameKind::StaticFull);
    EXPECT_EQ(scan->frames[20].kind, FrameKind::Dynamic);
    EXPECT_EQ(scan->frames[5].split, Split::Test);
    EXPECT_TRUE(scan->splitStated);
    // File: the first camera stands at (0, −2.5, 1), in front of a subject that faces −y. Here that is +z, height stays y.
    const Vec3d eye = scan->frames[0].camera.eye();
    EXPECT_NEAR(eye.x, 0, 1e-12);
    EXPECT_NEAR(eye.y, 1, 1e-12);
    EXPECT_NEAR(eye.z, 2.5, 1e-12);
    // The subject's left (+x) is seen on the right of a picture taken from the front; a higher point has a smaller row.
    const auto& camera = scan->frames[0].camera;
    EXPECT_GT(camera.pixelOf(camera.toView({0.3, 1, 0})).x, camera.cx);
    EXPECT_LT(camera.pixelOf(camera.toView({0, 1.5, 0})).y, camera.cy);
    // Labels are sorted by value, whatever their order in the file.
    ASSERT_EQ(scan->labels.size(), 3u);
    EXPECT_EQ(scan->labels[2].name, "top");
}

TEST(ScanFolder, keypointsFollowTheScansNamesAndNeverTheTrueOnes) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 2);
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    auto points = readKeypoints(*scan, scan->frames[0]);
    ASSERT_TRUE(points) << points.error().message;
    ASSERT_EQ(points->size(), 3u);
    EXPECT_DOUBLE_EQ((*points)[0].px.y, 20);  // nose is second in the file, first in the scan
    EXPECT_DOUBLE_EQ((*points)[1].px.y, 64);
    EXPECT_DOUBLE_EQ((*points)[1].confidence, 0.5);
    EXPECT_EQ((*points)[2].confidence, 0) << "null is a missing point whatever its confidence";
    // A file that has only the true positions is refused. The error names the missing key.
    writeText(scan->frames[0].keypointsPath, R"({"names":["nose"],"xy":[[1,2]]})");
    auto truthOnly = readKeypoints(*scan, scan->frames[0]);
    ASSERT_FALSE(truthOnly);
    EXPECT_TRUE(mentions(truthOnly.error().message, {"full_100.json", "detections"}));
}

TEST(ScanFolder, pointsOfHandsAreReadByNameAndKeptApart) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 2);
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_EQ(handKeypointNames().size(), 2 * kHandPoints);
    EXPECT_EQ(handKeypointNames()[kHandPoints], "thumb1_r");
    auto none = readHandKeypoints(*scan, scan->frames[0]);
    ASSERT_TRUE(none) << none.error().message;
    EXPECT_TRUE(none->empty());
    const char* const text = R"({"names":["index4_l","nose","pinky2_r"],"detections":[[1,2],[3,4],[5,6]],"confidence":[0.5,0.9,0.7]})";
    writeText(scan->frames[0].keypointsPath, text);
    const auto body = readKeypoints(*scan, scan->frames[0]), hands = readHandKeypoints(*scan, scan->frames[0]);
    ASSERT_TRUE(body && hands);
    EXPECT_EQ((*body)[0].px, Vec2d(3, 4));
    ASSERT_EQ(hands->size(), 2 * kHandPoints);
    EXPECT_EQ((*hands)[size_t(handKeypointNamed("index4_l"))].px, Vec2d(1, 2));
    EXPECT_DOUBLE_EQ((*hands)[size_t(handKeypointNamed("pinky2_r"))].confidence, 0.7);
    EXPECT_EQ((*hands)[0].confidence, 0);
    // A scan that lists points of hands has the same keypoints of the body as one that does not.
    builder.manifest["keypoint_names"].push_back("index4_l");
    builder.write();
    writeText(scan->frames[0].keypointsPath, text);
    auto listed = readScan(folder.path);
    ASSERT_TRUE(listed) << listed.error().message;
    EXPECT_EQ(listed->keypointNames, scan->keypointNames);
    writeText(scan->frames[0].keypointsPath, R"({"names":["index4_l"],"detections":[[1]]})");
    EXPECT_EQ(readHandKeypoints(*scan, scan->frames[0]).error().code, Code::CorruptData);
}

TEST(ScanFolder, namesOfWhatNoFrameBringsAreDropped) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path);
    for (auto& frame : builder.manifest["frames"])
        if (frame["name"] != "full_103") frame.erase("keypoints"), frame.erase("labels");
    builder.manifest["frames"][3]["labels"] = "labels.png";
    auto some = readScan(builder.write());
    ASSERT_TRUE(some) << some.error().message;
    EXPECT_EQ(some->keypointNames.size(), 3u);
    EXPECT_EQ(some->labels.size(), 3u);
    builder.manifest["frames"][3].erase("keypoints"), builder.manifest["frames"][3].erase("labels");
    auto none = readScan(builder.write());
    ASSERT_TRUE(none) << none.error().message;
    EXPECT_TRUE(none->keypointNames.empty()) << "so networks find keypoints, with names of their own";
    EXPECT_TRUE(none->labels.empty());
}

TEST(ScanFolder, keypointsMayHaveTheirOlderNameButDetectionsComeFirst) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 1);
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    const auto noseOf = [&](const char* text) {
        writeText(scan->frames[0].keypointsPath, text);
        auto points = readKeypoints(*scan, scan->frames[0]);
        EXPECT_TRUE(points) << points.error().message;
        return points ? (*points)[0].px : Vec2d(-1);
    };
    EXPECT_EQ(noseOf(R"({"names":["nose"],"xy":[[5,6]],"xy_noisy":[[3,4]]})"), Vec2d(3, 4));
    EXPECT_EQ(noseOf(R"({"names":["nose"],"xy":[[5,6]],"xy_noisy":[[3,4]],"detections":[[1,2]]})"), Vec2d(1, 2));
    EXPECT_EQ(noseOf(R"({"names":["nose"],"xy":"not even a list","detections":[[1,2]]})"), Vec2d(1, 2));
}

TEST(ScanFolder, masksMayBeAbsentAndHeldOutFramesAreChosenWhenNoneAreStated) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 20, 5);
    for (auto& frame : builder.manifest["frames"]) frame.erase("split"), frame.erase("mask");
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_FALSE(scan->splitStated);
    EXPECT_EQ(std::count_if(scan->frames.begin(), scan->frames.end(), [](const ScanFrame& f) { return f.split == Split::Test; }), 2);
    EXPECT_TRUE(scan->frames[0].maskPath.empty());
    auto mask = readFrameMask(scan->frames[0]);
    ASSERT_FALSE(mask);
    EXPECT_TRUE(mentions(mask.error().message, {"full_100", "no mask"}));
}

TEST(ScanFolder, masksOfZeroAndOneMeanTheSameAs255) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 2);
    auto scan = readScan(builder.write());
    ASSERT_TRUE(scan) << scan.error().message;
    cv::Mat mask = cv::imread(scan->frames[0].maskPath.string(), cv::IMREAD_GRAYSCALE);
    cv::imwrite(scan->frames[0].maskPath.string(), mask / 255);
    auto read = readFrameMask(scan->frames[0]);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(*std::max_element(read->pixels.begin(), read->pixels.end()), 255);
}

TEST(ScanFolder, radialLensIsTakenOutOfPixelsAndKeypointsAlike) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 2);
    builder.manifest["camera_model"] = "radial";
    builder.manifest["distortion"] = {-0.15, 0.02};
    builder.write();
    // A white dot drawn where the distorted projection of a known ray lands must come out where the pinhole puts it.
    const double x = 0.3, y = -0.4, r2 = x * x + y * y, f = 1 - 0.15 * r2 + 0.02 * r2 * r2;
    const cv::Point2d distorted(100 * x * f + 48, 100 * y * f + 64), pinhole(100 * x + 48, 100 * y + 64);
    cv::Mat dot = cv::Mat::zeros(ScanBuilder::kHeight, ScanBuilder::kWidth, CV_8U);
    cv::circle(dot, cv::Point(int(distorted.x), int(distorted.y)), 2, 255, -1);
    cv::imwrite((folder.path / "masks/full_100.png").string(), dot);
    nlohmann::json points = {{"names", {"nose"}}, {"detections", {{distorted.x, distorted.y}}}};
    writeText(folder.path / "keypoints/full_100.json", points.dump());
    auto scan = readScan(folder.path);
    ASSERT_TRUE(scan) << scan.error().message;
    auto mask = readFrameMask(scan->frames[0]);
    ASSERT_TRUE(mask) << mask.error().message;
    double sumX = 0, sumY = 0, sum = 0;
    for (uint32_t v = 0; v < mask->heightPx; ++v)
        for (uint32_t u = 0; u < mask->widthPx; ++u) {
            const double w = mask->pixels[v * mask->widthPx + u];
            sumX += w * (u + 0.5), sumY += w * (v + 0.5), sum += w;
        }
    EXPECT_NEAR(sumX / sum, pinhole.x, 0.7);  // the dot sits on whole pixels: half a pixel, and the stretch of its disc
    EXPECT_NEAR(sumY / sum, pinhole.y, 0.7);
    auto read = readKeypoints(*scan, scan->frames[0]);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_NEAR((*read)[0].px.x, pinhole.x, 0.05);  // OpenCV inverts with five fixed-point iterations
    EXPECT_NEAR((*read)[0].px.y, pinhole.y, 0.05);
}

TEST(ScanFolder, sharedScansReadWithTheirSplits) {
    const auto data = sharedData("scan-a/scan.json");
    if (!data) GTEST_SKIP() << "shared data (scan-a) is not on this machine";
    auto scan = readScan(data->parent_path());
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_EQ(scan->frames.size(), 174u);
    EXPECT_EQ(scan->keypointNames.size(), 24u);
    EXPECT_EQ(scan->labels.size(), 6u);
    // The subject stands at the origin: every full-body camera sees the point (0, 0.97, 0) inside the picture and inside the mask.
    int held = 0;
    for (const auto& frame : scan->frames) {
        held += frame.split == Split::Test;
        if (frame.kind != FrameKind::StaticFull) continue;
        const Vec3d view = frame.camera.toView({0, 0.97, 0});
        ASSERT_GT(view.z, 0.5);
        const Vec2d px = frame.camera.pixelOf(view);
        auto mask = readFrameMask(frame);
        ASSERT_TRUE(mask) << mask.error().message;
        EXPECT_EQ(mask->pixels[size_t(px.y) * mask->widthPx + size_t(px.x)], 255) << frame.name;
    }
    EXPECT_EQ(held, 15);  // 6 of 60 static, 9 of 90 dynamic
    auto points = readKeypoints(*scan, scan->frames[0]);
    ASSERT_TRUE(points) << points.error().message;
    EXPECT_DOUBLE_EQ((*points)[0].px.x, 185.657);
}

TEST(ScanFolder, truthMayBeGone) {
    // A folder without a skeleton, truth.json, geometry/ and posed/ can be read too.
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 3);
    builder.manifest["truth"] = "truth.json";
    builder.manifest["geometry"] = {{"template", "geometry/template.ply"}};
    EXPECT_TRUE(readScan(builder.write()));
}

}  // namespace
}  // namespace dpl
