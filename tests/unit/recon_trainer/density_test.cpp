// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/density.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dpl {
namespace {

struct Scene {
    TrainableSplats splats;
    AdamRows adam;
    DensityStatistics statistics;
    std::vector<RestTriangle<float>> rest;
    std::vector<float> size{0.02f, 0.02f, 0.02f};

    Scene() {
        splats.resize(6, 0);
        splats.triangle = {0, 0, 0, 1, 1, 2};
        splats.sizeFloorM.assign(3, 0.0f);
        for (uint32_t i = 0; i < 6; ++i) {
            float* row = splats.rows.data() + i * splats.stride;
            row[kRowU] = row[kRowV] = 0.3f;
            row[kRowLogScale1] = row[kRowLogScale2] = std::log(0.003f);
            row[kRowOpacityLogit] = 1;
            row[kRowSh] = float(i);  // identifies the splat
            splats.flags[i] = uint8_t(i % 2);
        }
        splats.indexTriangles(3);
        splats.activate(0, 6);
        adam.resize(6, splats.stride);
        for (uint32_t i = 0; i < 6; ++i) adam.steps[i] = i + 10;
        statistics.resize(6);
        for (int t = 0; t < 3; ++t) rest.push_back(restTriangle(Vec3f(0), Vec3f(0.03f, 0, 0), Vec3f(0, 0.03f, 0)));
    }
};

TEST(Density, clonesSmallSplitsLargeAndKeepsTheOrder) {
    Scene s;
    s.splats.rows[1 * s.splats.stride + kRowLogScale1] = std::log(0.015f);
    s.splats.activate(0, 6);
    s.statistics.gradientSum = {0, 5, 0, 3, 0, 0}, s.statistics.seen = {1, 1, 1, 1, 1, 0};
    const DensityReport r = densify(s.splats, s.adam, s.statistics, s.rest, s.size, {.seed = 1, .maxSplats = 100, .maxGrowth = 10}, 0);
    EXPECT_EQ(r.split, 1u);
    EXPECT_EQ(r.cloned, 1u);
    EXPECT_EQ(s.splats.count(), 8u);
    EXPECT_TRUE(std::is_sorted(s.splats.triangle.begin(), s.splats.triangle.end()));
    EXPECT_EQ(s.splats.triangleStart, (std::vector<uint32_t>{0, 4, 7, 8}));
    EXPECT_NEAR(s.splats.scaleM[1].x, 0.015f / 1.6f, 1e-6f);
    EXPECT_EQ(s.adam.steps[0], 10u) << "moments follow their splats";
    EXPECT_EQ(s.adam.steps[1], 0u) << "new ones start at zero";
    EXPECT_EQ(s.splats.flags[1], 1) << "flags are inherited";
    EXPECT_EQ(s.splats.rows[1 * s.splats.stride + kRowSh], 1.0f);
}

TEST(Density, prunesTheTransparentButNotTheLastOfATriangle) {
    Scene s;
    for (uint32_t i : {0u, 3u, 4u, 5u}) s.splats.rows[i * s.splats.stride + kRowOpacityLogit] = -7;
    s.splats.rows[4 * s.splats.stride + kRowOpacityLogit] = -6;
    s.splats.activate(0, 6);
    const DensityReport r = densify(s.splats, s.adam, s.statistics, s.rest, s.size, {}, 0);
    EXPECT_EQ(r.pruned, 2u);
    EXPECT_EQ(s.splats.triangle, (std::vector<uint32_t>{0, 0, 1, 2}));
    EXPECT_EQ(s.splats.rows[2 * s.splats.stride + kRowSh], 4.0f) << "the most opaque of the face stays";
}

TEST(Density, budgetAndUnseenSplatsAreRespected) {
    Scene s;
    s.statistics.gradientSum = {1, 2, 3, 4, 5, NAN}, s.statistics.seen = {1, 1, 1, 1, 0, 1};
    const DensityReport r = densify(s.splats, s.adam, s.statistics, s.rest, s.size, {.seed = 1, .maxSplats = 8, .maxGrowth = 10}, 0);
    EXPECT_EQ(s.splats.count(), 8u);
    EXPECT_EQ(r.cloned, 2u) << "the two strongest that were seen: 3 and 2";
    EXPECT_EQ(s.statistics.gradientSum, std::vector<float>(8, 0.0f));
}

}  // namespace
}  // namespace dpl
