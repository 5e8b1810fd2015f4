// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/body/swapped_sides.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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
    for (const bool is : swappedSides(scan, keypoints)) EXPECT_FALSE(is);
    const auto before = keypoints;
    std::vector<bool> truth(90, false);
    for (size_t f = 0; f < 90; ++f)
        if (f % 20 == 2 || f % 20 == 3) truth[f] = true, keypoints[f] = withSidesSwapped(keypoints[f], kNames);
    EXPECT_EQ(keypoints[2][1].px, before[2][2].px);
    EXPECT_EQ(withSidesSwapped(keypoints[2], kNames)[1].px, before[2][1].px) << "twice is the identity";
    // Where the sides cross, both answers explain the picture equally well.
    const auto found = swappedSides(scan, keypoints);
    size_t wrong = 0;
    for (size_t f = 0; f < 90; ++f) wrong += found[f] != truth[f] && std::abs(std::cos(0.1 * double(f))) > 0.35;
    EXPECT_EQ(wrong, 0u);
}

TEST(SwappedSides, heldOutFramesDecideNothingAboutTrainingFrames) {
    std::vector<std::vector<Keypoint>> keypoints;
    const Scan scan = walk(40, keypoints);
    keypoints[5] = withSidesSwapped(keypoints[5], kNames);
    const auto before = swappedSides(scan, keypoints);
    EXPECT_TRUE(before[5]);
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
    for (const bool is : swappedSides(scan, keypoints)) EXPECT_FALSE(is);
    EXPECT_TRUE(withSidesSwapped({}, kNames).empty());
    EXPECT_TRUE(swappedSides(Scan{}, {}).empty());
}

}  // namespace
}  // namespace dpl
