// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/swapped_sides.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

const std::vector<std::string> kNames{"nose", "shoulder_l", "shoulder_r", "wrist_l", "wrist_r", "ankle_l", "ankle_r"};

/** A walk seen from a camera that circles it: the sides cross in the picture. */
Scan walk(size_t frames, std::vector<std::vector<Keypoint>>& keypoints) {
    Scan scan;
    scan.keypointNames = kNames;
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (size_t i = 0; i < frames; ++i) {
        ScanFrame frame;
        frame.kind = FrameKind::Dynamic, frame.timeS = 0.2 * double(i), frame.camera.widthPx = 378, frame.camera.heightPx = 504;
        frame.split = i % 7 == 3 ? Split::Test : Split::Train;
        scan.frames.push_back(frame);
        keypoints.emplace_back();
        const double side = std::cos(0.1 * double(i)), step = 25 * std::sin(0.9 * double(i));
        for (size_t k = 0; k < kNames.size(); ++k) {
            const double half = k == 0 ? 0 : (k % 2 ? 1 : -1) * (20.0 + 5.0 * double(k));
            keypoints.back().push_back({Vec2d(190 + half * side + (k >= 5 ? (k % 2 ? step : -step) : 0), 60 + 60 * double(k)) +
                                            2.0 * Vec2d(normal(random), normal(random)),
                                        1.0});
        }
    }
    return scan;
}

TEST(SwappedSides, findsATenthOfTheFramesAndNoOther) {
    std::vector<std::vector<Keypoint>> keypoints;
    const Scan scan = walk(90, keypoints);
    for (const uint8_t parts : swappedSides(scan, keypoints)) EXPECT_EQ(parts, kNoneSwapped);
    const auto before = keypoints;
    std::vector<bool> truth(90, false);
    for (size_t f = 0; f < 90; ++f)
        if (f % 20 == 2 || f % 20 == 3) truth[f] = true, keypoints[f] = withSidesSwapped(keypoints[f], kNames);
    EXPECT_EQ(keypoints[2][1].px, before[2][2].px);
    EXPECT_EQ(withSidesSwapped(keypoints[2], kNames)[1].px, before[2][1].px) << "twice is the identity";
    // Where the sides cross, both answers explain the picture equally well.
    const auto found = swappedSides(scan, keypoints);
    size_t wrong = 0;
    for (size_t f = 0; f < 90; ++f)
        wrong += found[f] != (truth[f] ? kAllSwapped : kNoneSwapped) && std::abs(std::cos(0.1 * double(f))) > 0.35;
    EXPECT_EQ(wrong, 0u);
}

TEST(SwappedSides, heldOutFramesDecideNothingAboutTrainingFrames) {
    std::vector<std::vector<Keypoint>> keypoints;
    const Scan scan = walk(40, keypoints);
    keypoints[5] = withSidesSwapped(keypoints[5], kNames);
    const auto before = swappedSides(scan, keypoints);
    EXPECT_EQ(before[5], kAllSwapped);
    bool differs = false;
    for (size_t f = 0; f < 40; ++f)
        if (scan.frames[f].split == Split::Test) keypoints[f] = withSidesSwapped(keypoints[f], kNames);
    const auto after = swappedSides(scan, keypoints);
    for (size_t f = 0; f < 40; ++f) {
        if (scan.frames[f].split == Split::Train) {
            EXPECT_EQ(before[f], after[f]) << f;
        }
        differs |= before[f] != after[f];
    }
    EXPECT_TRUE(differs) << "the held-out keypoints were read";
}

TEST(SwappedSides, emptyAndMissingKeypointsAreNoEvidence) {
    std::vector<std::vector<Keypoint>> keypoints;
    const Scan scan = walk(12, keypoints);
    keypoints[3].clear();
    for (Keypoint& k : keypoints[4]) k.confidence = 0;
    for (const uint8_t parts : swappedSides(scan, keypoints)) EXPECT_EQ(parts, kNoneSwapped);
    EXPECT_TRUE(withSidesSwapped({}, kNames).empty());
    EXPECT_TRUE(swappedSides(Scan{}, {}).empty());
}

const std::vector<std::string> kBodyNames{"nose",    "ear_l",   "ear_r",   "shoulder_l", "shoulder_r", "elbow_l",
                                          "elbow_r", "wrist_l", "wrist_r", "hip_l",      "hip_r",      "knee_l",
                                          "knee_r",  "ankle_l", "ankle_r", "toe_l",      "toe_r"};

/** A standing body that faces +Z, seen by cameras all round it, with 1 % noise and a tenth of the keypoints far off. */
Scan orbit(size_t frames, std::vector<std::vector<Keypoint>>& keypoints) {
    Scan scan;
    scan.keypointNames = kBodyNames;
    const std::vector<Vec3d> body{{0, 1.6, 0.12},   {0.07, 1.6, 0},  {-0.07, 1.6, 0},  {0.2, 1.4, 0},  {-0.2, 1.4, 0}, {0.35, 1.15, 0},
                                  {-0.35, 1.15, 0}, {0.45, 0.9, 0},  {-0.45, 0.9, 0},  {0.1, 0.9, 0},  {-0.1, 0.9, 0}, {0.12, 0.5, 0},
                                  {-0.12, 0.5, 0},  {0.13, 0.08, 0}, {-0.13, 0.08, 0}, {0.15, 0, 0.2}, {-0.15, 0, 0.2}};
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    for (size_t f = 0; f < frames; ++f) {
        ScanFrame frame;
        frame.name = "full_" + std::to_string(f);
        frame.split = f % 9 == 4 ? Split::Test : Split::Train;
        const double angle = 2 * M_PI * double(f) / double(frames);
        const Vec3d eye(3 * std::sin(angle), 1.1, 3 * std::cos(angle));
        const Vec3d z = glm::normalize(Vec3d(0, 0.9, 0) - eye), x = glm::normalize(glm::cross(z, Vec3d(0, 1, 0))), y = glm::cross(z, x);
        frame.camera.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
        frame.camera.viewFromWorldTranslation = -frame.camera.viewFromWorldRotation * eye;
        frame.camera.widthPx = 378, frame.camera.heightPx = 504, frame.camera.fx = frame.camera.fy = 600;
        frame.camera.cx = 189, frame.camera.cy = 252;
        scan.frames.push_back(frame);
        keypoints.emplace_back();
        for (const Vec3d& p : body) {
            const double far = uniform(random) < 0.1 ? 40 : 0;
            keypoints.back().push_back(
                {frame.camera.pixelOf(frame.camera.toView(p)) + (6.0 + far) * Vec2d(normal(random), normal(random)), 1.0});
        }
    }
    return scan;
}

/** Swaps about a tenth of the frames: of four, two whole bodies, one only the legs and one only the upper body. */
std::vector<uint8_t> plantSwaps(const Scan& scan, std::vector<std::vector<Keypoint>>& keypoints) {
    std::mt19937 random(11);
    std::vector<uint8_t> planted(keypoints.size(), kNoneSwapped);
    size_t count = 0;
    for (size_t f = 0; f < keypoints.size(); ++f) {
        if (random() % 10 != 0) continue;
        planted[f] = std::array{kAllSwapped, kLowerSwapped, kAllSwapped, kUpperSwapped}[count++ % 4];
        keypoints[f] = withSidesSwapped(keypoints[f], scan.keypointNames, planted[f]);
    }
    return planted;
}

/** Parts of frames (two a frame) that are found swapped: how many of the found ones were planted, and how many of the planted were found.
 */
struct Found {
    double precision = 0, recall = 0;
    size_t planted = 0;
};
Found compare(const std::vector<uint8_t>& planted, const std::vector<uint8_t>& found, const Scan& scan, bool moving) {
    size_t right = 0, all = 0, wanted = 0;
    for (size_t f = 0; f < planted.size(); ++f) {
        if ((scan.frames[f].kind == FrameKind::Dynamic) != moving) continue;
        for (const uint8_t part : {kUpperSwapped, kLowerSwapped}) {
            wanted += (planted[f] & part) != 0, all += (found[f] & part) != 0;
            right += (planted[f] & found[f] & part) != 0;
        }
    }
    const Found out{all ? double(right) / double(all) : 1, wanted ? double(right) / double(wanted) : 1, wanted};
    std::printf("%s frames: %zu parts planted, precision %.3f, recall %.3f\n", moving ? "moving" : "still", wanted, out.precision,
                out.recall);
    return out;
}

TEST(SwappedSides, stillFramesAreHeldAgainstTheTriangulatedBody) {
    std::vector<std::vector<Keypoint>> keypoints;
    const Scan scan = orbit(80, keypoints);
    for (const uint8_t parts : swappedSides(scan, keypoints)) EXPECT_EQ(parts, kNoneSwapped);
    const auto planted = plantSwaps(scan, keypoints);
    const Found found = compare(planted, swappedSides(scan, keypoints), scan, false);
    ASSERT_GE(found.planted, 10u);
    EXPECT_GE(found.precision, 1.0);
    EXPECT_GE(found.recall, 0.8);  // seen from the side, left and right lie on each other, and a swap changes nothing
}

TEST(SwappedSides, aScanThatNamesTheSidesOfTheViewerIsTurnedBack) {
    std::vector<std::vector<Keypoint>> keypoints;
    Scan scan = orbit(40, keypoints);
    for (auto& frame : keypoints) frame = withSidesSwapped(frame, scan.keypointNames);
    scan.frames.push_back(scan.frames[0]);
    scan.frames.back().kind = FrameKind::Dynamic;
    keypoints.push_back(keypoints[0]);
    const auto found = swappedSides(scan, keypoints);
    for (const uint8_t parts : found) EXPECT_EQ(parts, kAllSwapped);
    EXPECT_NE(describeSwaps(scan, found).find("whole scan"), std::string::npos);
    EXPECT_TRUE(describeSwaps(scan, std::vector<uint8_t>(found.size(), kNoneSwapped)).empty());
}

TEST(SwappedSides, heldOutStillFramesDecideNothingAboutTrainingFrames) {
    std::vector<std::vector<Keypoint>> keypoints;
    const Scan scan = orbit(40, keypoints);
    keypoints[7] = withSidesSwapped(keypoints[7], kBodyNames, kLowerSwapped);
    const auto before = swappedSides(scan, keypoints);
    EXPECT_EQ(before[7], kLowerSwapped);
    for (size_t f = 0; f < 40; ++f)
        if (scan.frames[f].split == Split::Test)
            for (Keypoint& k : keypoints[f]) k.px = Vec2d(378, 504) - k.px;
    const auto after = swappedSides(scan, keypoints);
    for (size_t f = 0; f < 40; ++f)
        if (scan.frames[f].split == Split::Train) {
            EXPECT_EQ(before[f], after[f]) << f;
        }
}

TEST(SwappedSides, plantedSwapsInSharedScansAreFound) {
    bool any = false;
    for (const char* name : {"scan-a", "scan-c"}) {
        const auto folder = sharedData(name);
        if (!folder) continue;
        any = true;
        auto scan = readScan(*folder);
        ASSERT_TRUE(scan) << scan.error().message;
        std::vector<std::vector<Keypoint>> keypoints;
        for (const ScanFrame& frame : scan->frames) {
            auto read = readKeypoints(*scan, frame);
            ASSERT_TRUE(read) << read.error().message;
            keypoints.push_back(std::move(*read));
        }
        const auto clean = swappedSides(*scan, keypoints);
        const size_t wrong = size_t(std::count_if(clean.begin(), clean.end(), [](uint8_t parts) { return parts != kNoneSwapped; }));
        std::printf("%s: %zu of %zu clean frames taken for swapped\n", name, wrong, clean.size());
        EXPECT_EQ(wrong, 0u);
        const auto planted = plantSwaps(*scan, keypoints);
        const auto found = swappedSides(*scan, keypoints);
        for (const bool moving : {false, true}) {
            const Found f = compare(planted, found, *scan, moving);
            EXPECT_GE(f.precision, 0.95);
            EXPECT_GE(f.recall, 0.8);
        }
    }
    if (!any) GTEST_SKIP() << "shared data (scan-a, scan-c) is not on this machine";
}

}  // namespace
}  // namespace dpl
