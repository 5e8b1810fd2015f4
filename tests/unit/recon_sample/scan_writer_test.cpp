// SPDX-License-Identifier: Apache-2.0
// Writes a small sample scan, reads it with the product's reader and checks it against its truth.
#include "reconstruction/subject/sample/scan_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/subject/sample/motion.h"
#include "reconstruction/subject/sample/sample_frames.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "tests/unit/heard_task.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

SampleScanOptions tiny() {
    SampleScanOptions o = SampleScanOptions::small(3);
    o.widthPx = 96, o.heightPx = 128;
    o.fullFrames = 10, o.closeupFrames = 6, o.dynamicFrames = 10;
    o.samplesPerPixel = 2;
    return o;
}

fs::path scratch() {
    static const fs::path kFolder = [] {
        const fs::path p = fs::temp_directory_path() / ("doppel_sample_scan_" + std::to_string(::getpid()));
        fs::remove_all(p);
        fs::create_directories(p);
        return p;
    }();
    return kFolder;
}

class Cleanup : public ::testing::Environment {
    void TearDown() override { fs::remove_all(scratch()); }
};
const auto* const kCleanup = ::testing::AddGlobalTestEnvironment(new Cleanup);

const fs::path& scanFolder() {
    static const fs::path kFolder = [] {
        Jobs jobs(2);
        const fs::path folder = scratch() / "two";
        const Status made = makeSampleScan(folder, tiny(), jobs);
        EXPECT_TRUE(made) << made.error().message;
        return folder;
    }();
    return kFolder;
}

std::string bytesOf(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
Json jsonOf(const fs::path& path) {
    return Json::parse(bytesOf(path));
}

TEST(SampleScan, isReadByTheProductsReader) {
    const auto scan = readScan(scanFolder());
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames.size(), 26u);
    EXPECT_EQ(scan->keypointNames.size(), 24u);
    std::map<FrameKind, int> kinds, tests;
    for (const ScanFrame& f : scan->frames) {
        ++kinds[f.kind];
        tests[f.kind] += f.split == Split::Test;
        // After reading +Y is up, so cameras are above the floor and see the person in front of them.
        EXPECT_GT(f.camera.eye().y, 0.1) << f.name;
        EXPECT_GT(f.camera.toView({0, 0.9, 0}).z, 0) << f.name;
    }
    EXPECT_EQ(tests[FrameKind::StaticFull], 1);  // 10 %
    EXPECT_EQ(tests[FrameKind::StaticCloseup], 0);
    EXPECT_EQ(tests[FrameKind::Dynamic], 1);
}

TEST(SampleScan, masksAndLabelsAgreeAndShowThePerson) {
    const auto scan = readScan(scanFolder());
    ASSERT_TRUE(scan);
    for (const ScanFrame& f : scan->frames) {
        const auto mask = readFrameMask(f);
        const auto labels = readFrameLabels(f);
        const auto image = readFrameImage(f);
        ASSERT_TRUE(mask && labels && image) << f.name;
        size_t person = 0;
        std::array<size_t, 256> count{};
        for (size_t i = 0; i < mask->pixels.size(); ++i) {
            ASSERT_EQ(mask->pixels[i] == 255, labels->pixels[i] != 0) << f.name;
            ASSERT_LE(labels->pixels[i], 5);
            person += mask->pixels[i] == 255;
            ++count[labels->pixels[i]];
        }
        EXPECT_GT(person, mask->pixels.size() / 40) << f.name;
        if (f.kind == FrameKind::StaticCloseup) continue;
        for (int label = 1; label <= 5; ++label) EXPECT_GT(count[label], 8u) << f.name << " label " << label;
    }
}

TEST(SampleScan, truthProjectsOntoItsKeypoints) {
    const Json scan = jsonOf(scanFolder() / "scan.json"), truth = jsonOf(scanFolder() / "truth.json");
    double squares = 0;
    int count = 0;
    for (size_t i = 0; i < scan["frames"].size(); ++i) {
        const Json& camera = scan["frames"][i]["camera"];
        const Json keypoints = jsonOf(scanFolder() / scan["frames"][i]["keypoints"].get<std::string>());
        for (size_t k = 0; k < 24; ++k) {
            if (keypoints["xy"][k].is_null()) continue;
            double view[3];
            for (int r = 0; r < 3; ++r) {
                view[r] = camera["t"][r];
                for (int c = 0; c < 3; ++c)
                    view[r] += camera["R"][3 * r + c].get<double>() * truth["frames"][i]["keypoints_world"][k][c].get<double>();
            }
            const double u = camera["fx"].get<double>() * view[0] / view[2] + camera["cx"].get<double>();
            const double v = camera["fy"].get<double>() * view[1] / view[2] + camera["cy"].get<double>();
            // Files round to 1e-7 m and 1e-3 px. For points 6 cm before the eye, 1e-7 m is a larger share of a pixel.
            ASSERT_NEAR(u, keypoints["xy"][k][0].get<double>(), 0.01);
            ASSERT_NEAR(v, keypoints["xy"][k][1].get<double>(), 0.01);
            const double sigma = keypoints["noise_sigma_px"][k];
            squares += std::pow((keypoints["detections"][k][0].get<double>() - keypoints["xy"][k][0].get<double>()) / sigma, 2);
            ++count;
        }
    }
    ASSERT_GT(count, 300);
    EXPECT_NEAR(squares / count, 1, 0.3);  // mean of more than 300 squared normals: 3 standard deviations are 0.25
}

TEST(SampleScan, fullFramesSeeMostKeypoints) {
    const Json keypoints = jsonOf(scanFolder() / "keypoints" / "full_000.json");
    int visible = 0;
    for (int v : keypoints["visibility"]) visible += v == 2;
    EXPECT_GE(visible, 16);
    for (size_t k = 0; k < 24; ++k) {
        const double c = keypoints["confidence"][k];
        EXPECT_EQ(c > 0.7, keypoints["visibility"][k] == 2);
    }
}

TEST(SampleScan, geometryFilesHaveTheSizesOfTheFormat) {
    const Json scan = jsonOf(scanFolder() / "scan.json"), truth = jsonOf(scanFolder() / "truth.json");
    const size_t vertices = scan["geometry"]["vertex_count"], triangles = scan["geometry"]["triangle_count"];
    EXPECT_EQ(fs::file_size(scanFolder() / "geometry" / "weights.bin"), 12 + vertices * 4 * 8);
    const std::string ply = bytesOf(scanFolder() / "geometry" / "template.ply");
    const size_t header = ply.find("end_header\n") + 11;
    EXPECT_EQ(ply.size(), header + vertices * 13 + triangles * 14);
    size_t posed = 0;
    for (const Json& f : truth["frames"])
        if (!f["posed"].is_null()) {
            ++posed;
            EXPECT_EQ(fs::file_size(scanFolder() / f["posed"].get<std::string>()), vertices * 12);
        }
    EXPECT_GE(posed, 4u);
    double top = 0;  // z is up in the files
    for (const Json& p : scan["skeleton"]["rest_positions"]) top = std::max(top, p[2].get<double>());
    EXPECT_GT(top, 1.4);
}

TEST(SampleScan, finePicturesOfOneHeldOutFrameAKindShowTheSameView) {
    const Json scan = jsonOf(scanFolder() / "scan.json");
    std::set<std::string> kinds;
    for (const Json& f : scan["frames"]) {
        const std::string name = f["name"];
        const fs::path finePath = scanFolder() / "hires" / "x4" / (name + ".mask.png");
        if (!fs::exists(finePath)) continue;
        const cv::Mat fine = cv::imread(finePath.string(), cv::IMREAD_GRAYSCALE);
        EXPECT_EQ(f["split"], "test");
        kinds.insert(f["kind"]);
        const cv::Mat mask = cv::imread((scanFolder() / "masks" / (name + ".png")).string(), cv::IMREAD_GRAYSCALE);
        ASSERT_EQ(fine.size(), mask.size() * 4);
        cv::Mat small;
        cv::resize(fine, small, mask.size(), 0, 0, cv::INTER_AREA);
        // They must agree away from the outline. On the outline, the two samples per pixel decide by chance.
        EXPECT_LE(cv::countNonZero((small == 0) & (mask == 255)) + cv::countNonZero((small == 255) & (mask == 0)),
                  0.005 * cv::countNonZero(mask));
        EXPECT_EQ(cv::imread((scanFolder() / "hires" / "x4" / (name + ".jpg")).string()).size(), fine.size());
    }
    EXPECT_EQ(kinds, (std::set<std::string>{"static_full", "dynamic"}));
}

TEST(SampleScan, sameBytesOnOneAndThreeThreads) {
    Jobs jobs(3);
    const fs::path other = scratch() / "three";
    ASSERT_TRUE(makeSampleScan(other, tiny(), jobs));
    size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(scanFolder())) {
        if (!entry.is_regular_file()) continue;
        ++files;
        ASSERT_EQ(bytesOf(entry.path()), bytesOf(other / fs::relative(entry.path(), scanFolder()))) << entry.path();
    }
    EXPECT_GT(files, 26u * 4);
}

TEST(SampleFrames, areThoseOfTheScanWithoutItsLoss) {
    Jobs one(1), two(2);
    const Subject subject = makeSubject(tiny().seed, two);
    const auto frames = sampleFrames(subject, tiny(), one);
    ASSERT_TRUE(frames);
    const auto scan = readScan(scanFolder());
    ASSERT_TRUE(scan);
    ASSERT_EQ(frames->size(), scan->frames.size());
    for (size_t f = 0; f < frames->size(); ++f) {
        const TrainFrame& frame = (*frames)[f];
        const ScanFrame& written = scan->frames[f];
        ASSERT_EQ(frame.name, written.name);
        EXPECT_EQ(frame.kind, written.kind) << frame.name;
        EXPECT_NEAR(glm::distance(frame.camera.eye(), written.camera.eye()), 0, 1e-6) << frame.name;
        const auto picture = frame.picture.get();
        const auto mask = readFrameMask(written), labels = readFrameLabels(written);
        const auto image = readFrameImage(written);
        ASSERT_TRUE(picture && mask && labels && image) << frame.name;
        EXPECT_TRUE((*picture)->mask.pixels == mask->pixels) << frame.name;
        EXPECT_TRUE((*picture)->labels.pixels == labels->pixels) << frame.name;
        ASSERT_EQ((*picture)->image.pixels.size(), image->pixels.size());
        double strays = 0;
        for (size_t i = 0; i < image->pixels.size(); ++i) strays += std::abs(int((*picture)->image.pixels[i]) - int(image->pixels[i]));
        EXPECT_LT(strays / double(image->pixels.size()), 6) << frame.name << ": JPEG loses 1 to 4.2 levels, two rays a pixel are noisy";
    }
}

TEST(SampleFrames, postersChangeTheRoomAndNotThePerson) {
    Jobs jobs(2);
    const Subject subject = makeSubject(tiny().seed, jobs);
    SampleScanOptions furnished = tiny();
    furnished.posters = true;
    const auto plain = sampleFrames(subject, tiny(), jobs), printed = sampleFrames(subject, furnished, jobs);
    ASSERT_TRUE(plain && printed);
    ASSERT_EQ(plain->size(), printed->size());
    for (size_t f = 0; f < plain->size(); ++f) {
        const FramePicture &before = **(*plain)[f].picture.get(), &after = **(*printed)[f].picture.get();
        ASSERT_TRUE(before.mask.pixels == after.mask.pixels && before.labels.pixels == after.labels.pixels) << (*plain)[f].name;
        const int rows = int(before.mask.heightPx), columns = int(before.mask.widthPx);
        const cv::Mat mask(rows, columns, CV_8U, const_cast<uint8_t*>(before.mask.pixels.data()));
        cv::Mat inside, room;
        cv::erode(mask, inside, cv::Mat::ones(3, 3, CV_8U));
        cv::erode(255 - mask, room, cv::Mat::ones(3, 3, CV_8U));
        const auto grey = [&](const FramePicture& of) {
            cv::Mat out;
            cv::cvtColor(cv::Mat(rows, columns, CV_8UC3, const_cast<uint8_t*>(of.image.pixels.data())), out, cv::COLOR_RGB2GRAY);
            return out;
        };
        const cv::Mat a = grey(before), b = grey(after);
        ASSERT_GT(cv::countNonZero(inside), 300) << (*plain)[f].name;
        // A pixel inside may see the room past an edge by one of its rays.
        EXPECT_LT(cv::countNonZero((a != b) & inside), 0.02 * cv::countNonZero(inside)) << (*plain)[f].name;
        if ((*plain)[f].kind != FrameKind::StaticFull) continue;  // close-ups see little of the room
        cv::Mat edgesA, edgesB;
        cv::Laplacian(a, edgesA, CV_32F);
        cv::Laplacian(b, edgesB, CV_32F);
        EXPECT_GT(cv::mean(cv::abs(edgesB), room)[0], 2 * cv::mean(cv::abs(edgesA), room)[0]) << (*plain)[f].name;
    }
}

TEST(SampleFrames, aStopIsHeard) {
    Jobs jobs(2);
    const Subject subject = makeSubject(tiny().seed, jobs);
    test::HeardTask task(2);
    const TaskScope scope(&task);
    const auto frames = sampleFrames(subject, tiny(), jobs);
    ASSERT_FALSE(frames);
    EXPECT_EQ(frames.error().code, Code::Cancelled);
}

TEST(SampleFrames, everyTriangleHasTheLabelOfItsLayer) {
    Jobs jobs(2);
    const Subject subject = makeSubject(1, jobs);
    const std::vector<uint8_t> labels = triangleLabels(subject);
    ASSERT_EQ(labels.size(), subject.mesh.triangles.size());
    std::set<uint8_t> seen(labels.begin(), labels.end());
    EXPECT_FALSE(seen.contains(0)) << "a triangle of no layer";
    EXPECT_GE(seen.size(), 4u);
}

TEST(SampleScan, handsMoveOnlyWhereAskedAndChangeNothingElse) {
    // As before there were hands that move: by hand from `doppel sample --small --seed 1`.
    const TruthPose raised = SampleMotion::dynamicSequence(1, 18.75).pose(18.75 * 12 / 31);
    EXPECT_LT(glm::length(raised.rotations[kLeftIndex1] - Vec3d(0.058593275, 0.00496045, -0.357427862)), 1e-8);
    EXPECT_LT(glm::length(raised.rotations[kLeftElbow] - Vec3d(0, -0.351640297, 0)), 1e-8);

    Jobs jobs(2);
    SampleScanOptions options = tiny();
    options.fingers = true;
    const fs::path moved = scratch() / "hands";
    const Status made = makeSampleScan(moved, options, jobs);
    ASSERT_TRUE(made) << made.error().message;
    const Json plain = jsonOf(scanFolder() / "scan.json"), handed = jsonOf(moved / "scan.json");
    EXPECT_EQ(plain["keypoint_names"], handed["keypoint_names"]);
    const Json plainTruth = jsonOf(scanFolder() / "truth.json"), handedTruth = jsonOf(moved / "truth.json");
    std::map<std::string, size_t> heldOut;
    for (size_t f = 0; f < plain["frames"].size(); ++f) {
        const std::string name = plain["frames"][f]["name"];
        EXPECT_EQ(plain["frames"][f]["camera"], handed["frames"][f]["camera"]);
        if (handed["frames"][f].contains("closeup_of") && handed["frames"][f]["split"] == "test")
            ++heldOut[handed["frames"][f]["closeup_of"]];
        const Json a = jsonOf(scanFolder() / "keypoints" / (name + ".json")), b = jsonOf(moved / "keypoints" / (name + ".json"));
        ASSERT_EQ(a["names"].size(), 24u);
        ASSERT_EQ(b["names"].size(), 64u);
        EXPECT_EQ(b["names"][24], "thumb1_l");
        EXPECT_EQ(b["names"][63], "pinky4_r");
        const Json &before = plainTruth["frames"][f], &after = handedTruth["frames"][f];
        EXPECT_FALSE(before.contains("hand_keypoints_world"));
        ASSERT_EQ(after["hand_keypoints_world"].size(), 40u);
        for (size_t k = 0; k < 24; ++k) {
            EXPECT_EQ(a["xy"][k], b["xy"][k]);
            if (a["visibility"][k] == b["visibility"][k]) {  // moved fingers hide other points
                EXPECT_EQ(a["detections"][k], b["detections"][k]);
            }
            EXPECT_EQ(before["keypoints_world"][k], after["keypoints_world"][k]);
        }
        for (size_t j = 0; j < kLeftIndex1; ++j) EXPECT_EQ(before["rotations"][j], after["rotations"][j]);
        for (size_t j = kLeftIndex1; plain["frames"][f]["kind"] != "dynamic" && j < kBuiltinJointCount; ++j)
            EXPECT_EQ(before["rotations"][j], Json({0.0, 0.0, 0.0}));
    }
    EXPECT_TRUE(heldOut.empty()) << "one close-up of a hand is too few to hold it out";
}

TEST(SampleScan, gesturesReachFistAndSpreadAndStillHandsStayClose) {
    const auto curl = [](const HandPose& hand) {
        double sum = 0;
        for (int f = 0; f < kThumb; ++f) sum += hand[f][kBase] + hand[f][kMiddleJoint] + hand[f][kEndJoint];
        return sum / (3 * kThumb);
    };
    double least = 1e9, most = -1e9;
    std::set<std::string> poses;
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        const HandMotion motion(seed, 18.75);
        for (const bool left : {true, false}) {
            const HandPose hand = seededHand(seed, left);
            EXPECT_EQ(motion.at(left, 0), hand);
            for (int f = 0; f < kThumb; ++f)
                for (const HandTurn t : {kBase, kMiddleJoint, kEndJoint}) {
                    EXPECT_GE(hand[f][t], 0);
                    EXPECT_LE(hand[f][t], glm::radians(60.0) + 1e-9);
                }
            EXPECT_LE(hand[kIndex][kSpread] - hand[kPinky][kSpread], glm::radians(20.0) + 1e-9);
            poses.insert(std::to_string(curl(hand)));
            for (uint32_t i = 0; i < 5; ++i)
                for (int f = 0; f < kFingerCount; ++f)
                    for (int t = 0; t < kHandTurnCount; ++t) EXPECT_NEAR(stillHand(seed, left, i)[f][t], hand[f][t], glm::radians(2.6));
            for (double t = 0; t < 18.75; t += 0.05)
                least = std::min(least, curl(motion.at(left, t))), most = std::max(most, curl(motion.at(left, t)));
        }
    }
    EXPECT_EQ(poses.size(), 12u) << "each hand of each seed has a pose of its own";
    EXPECT_GT(most, glm::radians(65.0));
    EXPECT_LT(least, 0);
}

TEST(SampleScan, refusesAFolderInUseAndLeavesNothingWhenStopped) {
    Jobs jobs(2);
    const fs::path used = scratch() / "used";
    fs::create_directories(used);
    std::ofstream(used / "thesis.txt") << "years of work";
    const Status refused = makeSampleScan(used, tiny(), jobs);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::InvalidArgument);
    EXPECT_NE(refused.error().message.find("used"), std::string::npos);
    EXPECT_TRUE(fs::exists(used / "thesis.txt"));

    const fs::path stopped = scratch() / "stopped";
    test::HeardTask task(2);
    const TaskScope scope(&task);
    const Status cancelled = makeSampleScan(stopped, tiny(), jobs);
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(cancelled.error().code, Code::Cancelled);
    EXPECT_FALSE(fs::exists(stopped));
    EXPECT_FALSE(fs::exists(stopped.string() + ".partial"));

    SampleScanOptions bad = tiny();
    bad.widthPx = 0;
    EXPECT_EQ(makeSampleScan(scratch() / "bad", bad, jobs).error().code, Code::InvalidArgument);
}

}  // namespace
}  // namespace dpl
