// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/garment_distance.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dpl {
namespace {

struct Sheet {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
};

/** A level sheet [0, widthM] × [0, 1] at a height, in `columns` × 20 squares. */
Sheet sheet(float widthM, float heightM, uint32_t columns = 20) {
    Sheet s;
    constexpr uint32_t kRows = 20;
    for (uint32_t j = 0; j <= kRows; ++j)
        for (uint32_t i = 0; i <= columns; ++i)
            s.positions.push_back({widthM * float(i) / float(columns), heightM, float(j) / float(kRows)});
    for (uint32_t j = 0; j < kRows; ++j)
        for (uint32_t i = 0; i < columns; ++i) {
            const uint32_t a = j * (columns + 1) + i, c = a + columns + 1;
            s.triangles.push_back({a, a + 1, c}), s.triangles.push_back({a + 1, c + 1, c});
        }
    return s;
}

double distanceMm(const Sheet& a, const Sheet& b) {
    Jobs jobs(2);
    return 1000 * garmentDistanceM({"top", a.triangles, b.triangles, b.triangles}, a.positions, b.positions, jobs);
}

TEST(GarmentDistance, ofParallelSheetsIsTheirGap) {
    EXPECT_NEAR(distanceMm(sheet(1, 0), sheet(1, 0.03f)), 30, 1e-3);
    EXPECT_NEAR(distanceMm(sheet(1, 0), sheet(1, 0)), 0, 1e-3);
}

TEST(GarmentDistance, isMeanOverTheAreaOfBothWays) {
    // From the wide sheet half of the area is 0 to 1 m away, 0.25 m in the mean; from the narrow one nothing is.
    EXPECT_NEAR(distanceMm(sheet(2, 0), sheet(1, 0)), 0.5 * 250, 2);
    EXPECT_NEAR(distanceMm(sheet(1, 0), sheet(2, 0)), 0.5 * 250, 2) << "the order does not matter";
    EXPECT_NEAR(distanceMm(sheet(2, 0, 120), sheet(1, 0)), 0.5 * 250, 2) << "nor does the number of triangles";
}

TEST(GarmentDistance, unseenTruthIsNotMissed) {
    const Sheet avatar = sheet(1, 0), truth = sheet(2, 0);
    GarmentPair pair{"top", avatar.triangles, truth.triangles, {}};
    for (const Triangle& t : truth.triangles)
        if (std::max({truth.positions[t.x].x, truth.positions[t.y].x, truth.positions[t.z].x}) < 1.001f) pair.seenTruth.push_back(t);
    Jobs jobs(2);
    EXPECT_NEAR(1000 * garmentDistanceM(pair, avatar.positions, truth.positions, jobs), 0, 1e-3);
}

TEST(GarmentDistance, nothingHasNoDistance) {
    EXPECT_EQ(distanceMm(sheet(1, 0), {}), 0);
}

TEST(GarmentPairs, areGarmentsThatTheTruthSimulates) {
    MeshData avatar;
    avatar.triangles.assign(9, Triangle(0, 1, 2));
    avatar.layers = {
        {"body", "body", 0, 3, 0, 2}, {"top", "garment", 3, 3, 2, 3}, {"shoes", "garment", 6, 3, 5, 3}, {"hair", "hair", 9, 3, 8, 1}};
    TrueMesh truth;
    truth.triangles.assign(10, Triangle(0, 1, 2));
    truth.parts = {{"body", 0, 2, false}, {"top", 2, 3, true}, {"shoes", 5, 3, false}, {"top", 8, 2, true}};
    const std::vector<uint8_t> seen{1, 1, 1, 1, 0, 1, 1, 1, 1, 1};
    const auto pairs = garmentPairs(avatar, truth, seen);
    ASSERT_EQ(pairs.size(), 1u);
    EXPECT_EQ(pairs[0].name, "top");
    EXPECT_EQ(pairs[0].avatar.size(), 3u);
    EXPECT_EQ(pairs[0].truth.size(), 5u) << "two parts with this label";
    EXPECT_EQ(pairs[0].seenTruth.size(), 4u);
    EXPECT_TRUE(garmentPairs(avatar, truth, std::vector<uint8_t>(10, 0)).empty()) << "no picture shows one";
}

}  // namespace
}  // namespace dpl
