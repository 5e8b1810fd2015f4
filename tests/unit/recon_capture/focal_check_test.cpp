// SPDX-License-Identifier: Apache-2.0
// The focal length that keypoints tell, against cameras whose focal length is known.
#include "reconstruction/input/capture/focal_check.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace dpl {
namespace {

constexpr double kFocalPx = 400, kWidthPx = 378, kHeightPx = 504;

Camerad lookingAt(const Vec3d& eye, const Vec3d& target) {
    const Vec3d forward = glm::normalize(target - eye), right = glm::normalize(glm::cross(forward, Vec3d(0, 1, 0)));
    const Vec3d down = glm::cross(forward, right);
    Camerad camera;
    camera.fx = camera.fy = kFocalPx, camera.cx = kWidthPx / 2, camera.cy = kHeightPx / 2;
    camera.widthPx = uint32_t(kWidthPx), camera.heightPx = uint32_t(kHeightPx);
    camera.viewFromWorldRotation = glm::transpose(Mat3d(right, down, forward));
    camera.viewFromWorldTranslation = -camera.viewFromWorldRotation * eye;
    return camera;
}

/** A standing figure of 20 keypoints, seen from an orbit of 24 cameras at 2.4 m and from `closeups` cameras at 0.7 m from single keypoints,
 *  with `noisePx` on each coordinate and one in twenty keypoints anywhere. */
std::vector<KeypointTrack> orbit(int closeups, double noisePx, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, noisePx);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::vector<Vec3d> points;
    for (int k = 0; k < 20; ++k) points.emplace_back(0.6 * (uniform(random) - 0.5), 1.7 * uniform(random), 0.3 * (uniform(random) - 0.5));
    std::vector<Camerad> cameras;
    const auto around = [](double turn, double distance, double height) {
        return Vec3d(distance * std::sin(turn), height, distance * std::cos(turn));
    };
    for (int i = 0; i < 24; ++i)
        cameras.push_back(lookingAt(around(2 * std::numbers::pi * i / 24, 2.4, 1.3 + 0.3 * (i % 2)), {0, 0.85, 0}));
    for (int i = 0; i < closeups; ++i) {
        const Vec3d target = points[size_t(i) % points.size()];
        cameras.push_back(lookingAt(target + around(1.3 * i, 0.7, 0.1), target));
    }
    std::vector<KeypointTrack> tracks(points.size());
    for (const Camerad& camera : cameras)
        for (size_t k = 0; k < points.size(); ++k) {
            Vec2d px = camera.pixelOf(camera.toView(points[k])) + Vec2d(noise(random), noise(random));
            if (uniform(random) < 0.05) px = {kWidthPx * uniform(random), kHeightPx * uniform(random)};
            if (px.x >= 0 && px.y >= 0 && px.x < kWidthPx && px.y < kHeightPx) tracks[k].push_back({camera, px, 0.9});
        }
    return tracks;
}

std::vector<KeypointTrack> withFocalTimes(std::vector<KeypointTrack> tracks, double factor) {
    for (auto& track : tracks)
        for (auto& seen : track) seen.camera.fx *= factor, seen.camera.fy *= factor;
    return tracks;
}

TEST(FocalCheck, findsTheFactorThroughNoiseAndOutliers) {
    for (uint32_t seed = 1; seed <= 3; ++seed)
        for (const double wrong : {0.6, 0.8, 1.0, 1.2, 1.6}) {
            const auto estimate = estimateFocalFactor(withFocalTimes(orbit(20, 1.5, seed), wrong));
            ASSERT_TRUE(estimate);
            EXPECT_NEAR(estimate->factor * wrong, 1, 0.02) << "seed " << seed << ", focal lengths times " << wrong;
            if (wrong == 1.0)
                EXPECT_LT(estimate->missAsGivenPx, 1.05 * estimate->missPx);
            else
                EXPECT_GT(estimate->missAsGivenPx, 1.3 * estimate->missPx);
        }
}

TEST(FocalCheck, isExactWithoutNoise) {
    const auto clean = withFocalTimes(orbit(20, 0, 4), 1.25);
    EXPECT_NEAR(estimateFocalFactor(clean)->factor, 0.8, 0.005);
}

TEST(FocalCheck, tellsThatAnOrbitAloneTellsLittle) {
    // 10 % off: the triangulated figure shrinks about the point that all cameras look at, and the misses hardly grow.
    const auto with = estimateFocalFactor(withFocalTimes(orbit(20, 1.5, 5), 1.1)),
               without = estimateFocalFactor(withFocalTimes(orbit(0, 1.5, 5), 1.1));
    ASSERT_TRUE(with && without);
    EXPECT_LT(without->missAsGivenPx / without->missPx, with->missAsGivenPx / with->missPx);
}

TEST(FocalCheck, needsEnoughKeypointsAndRefusesBrokenOnes) {
    EXPECT_FALSE(estimateFocalFactor({}));
    auto few = orbit(0, 0, 6);
    few.resize(3);
    for (auto& track : few) track.resize(3);
    EXPECT_FALSE(estimateFocalFactor(few)) << "three rays a keypoint";
    auto behind = orbit(0, 0, 7);
    for (auto& track : behind)
        for (auto& seen : track) seen.camera.viewFromWorldTranslation.z -= 10;
    EXPECT_TRUE(missesPx(behind, 1).empty()) << "all points behind all cameras";
}

}  // namespace
}  // namespace dpl
