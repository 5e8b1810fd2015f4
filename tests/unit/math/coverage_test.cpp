// SPDX-License-Identifier: Apache-2.0
// Coverage samples a pixel: they follow the pixel size at the subject, and numbers that are not finite give one sample.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "sdk/math/coverage.h"
#include "tests/not_finite.h"

namespace dpl {
namespace {

const Vec3f kSubject{0, 1, 0};
constexpr float kTrainedM = 0.002f;

/** Looks along +z at the subject, from the distance at which a pixel there has the size pixelM. */
Cameraf cameraOf(float pixelM, float focalPx = 500) {
    Cameraf c;
    c.widthPx = 640, c.heightPx = 480, c.fx = c.fy = focalPx, c.cx = 320, c.cy = 240;
    c.viewFromWorldTranslation = {0, -1, pixelM * focalPx};
    return c;
}

uint32_t samplesAt(float pixelM) {
    const Cameraf view = cameraOf(pixelM);
    return coverageSamples(kTrainedM, kSubject, {&view, 1});
}

TEST(CoverageSamples, areFourWherePixelsAreAQuarterCoarserThanTrained) {
    for (const float times : {0.01f, 0.5f, 1.0f, 1.24f}) EXPECT_EQ(samplesAt(times * kTrainedM), 1u) << times;
    for (const float times : {1.26f, 2.0f, 4.0f, 100.0f}) EXPECT_EQ(samplesAt(times * kTrainedM), kCoverageSamples) << times;
}

TEST(CoverageSamples, followFocalLengthAsTheyFollowDistance) {
    Cameraf view = cameraOf(kTrainedM);
    for (const float times : {2.0f, 0.5f}) {
        Cameraf other = view.scaled(times);
        EXPECT_EQ(coverageSamples(kTrainedM, kSubject, {&other, 1}), times < 1 ? kCoverageSamples : 1u);
    }
}

TEST(CoverageSamples, areThoseOfTheFinerEyeForBoth) {
    const Cameraf coarse = cameraOf(1.5f * kTrainedM), fine = cameraOf(1.1f * kTrainedM);
    const Cameraf both[] = {coarse, fine}, swapped[] = {fine, coarse}, coarser[] = {coarse, cameraOf(3 * kTrainedM)};
    EXPECT_EQ(coverageSamples(kTrainedM, kSubject, both), 1u);
    EXPECT_EQ(coverageSamples(kTrainedM, kSubject, swapped), 1u);
    EXPECT_EQ(coverageSamples(kTrainedM, kSubject, coarser), kCoverageSamples);
}

TEST(CoverageSamples, areOneWhereNothingIsKnown) {
    const Cameraf far = cameraOf(10 * kTrainedM);
    for (const float trained : {0.0f, -1.0f, kNan, kInfinity, -kInfinity})
        EXPECT_EQ(coverageSamples(trained, kSubject, {&far, 1}), 1u) << trained;
    EXPECT_EQ(coverageSamples(kTrainedM, kSubject, {}), 1u);
    for (const float bad : {kNan, kInfinity, -kInfinity, -5.0f, 0.0f}) {
        std::vector<Cameraf> views(3, far);
        views[1].viewFromWorldTranslation.z = bad;  // 0 and below: the subject is beside or behind that view
        EXPECT_EQ(coverageSamples(kTrainedM, kSubject, views), bad == kInfinity ? kCoverageSamples : 1u) << bad;
        EXPECT_EQ(coverageSamples(kTrainedM, kSubject, {&views[1], 1}), 1u) << bad;
        if (!std::isfinite(bad)) {
            EXPECT_EQ(coverageSamples(kTrainedM, {0, 1, bad}, {&far, 1}), 1u) << "subject at " << bad;
        }
        views[1] = far, views[1].fx = views[1].fy = bad;
        EXPECT_EQ(coverageSamples(kTrainedM, kSubject, {&views[1], 1}), 1u) << "focal length " << bad;
    }
}

TEST(CoverageSamples, averageToTheCentreAndReachNoFarther) {
    float sumX = 0, sumY = 0, reach = 0;
    for (const auto& place : kCoverageSamplePx) {
        sumX += place[0] - 0.5f, sumY += place[1] - 0.5f;
        reach = std::max({reach, std::abs(place[0] - 0.5f), std::abs(place[1] - 0.5f)});
    }
    EXPECT_EQ(sumX, 0);
    EXPECT_EQ(sumY, 0);
    EXPECT_EQ(reach, kCoverageReachPx);
}

}  // namespace
}  // namespace dpl
