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

/** The sheet `by` metres farther along x. */
Sheet slid(Sheet s, float by) {
    for (Vec3f& p : s.positions) p.x += by;
    return s;
}

/** Distances of a garment that slid along the true one after a still frame in which it lay `gapM` above it, millimetres. */
struct Slip {
    double nearestMm, pointMm;
};
Slip slipOf(float byM, float gapM) {
    Jobs jobs(2);
    const Sheet still = slid(sheet(1, gapM), 1), truth = sheet(3, 0, 60), now = slid(still, byM);
    const GarmentPair pair{"top", still.triangles, truth.triangles, {}};
    GarmentPair seen = pair;
    seen.seenTruth = truth.triangles;
    const std::vector<Vec3f> up(still.positions.size(), Vec3f(0, -1, 0));  // as the sheets face
    const std::vector<GarmentPlaces::Still> stills{{still.positions, up, truth.positions}};
    const GarmentPlaces places(seen, stills, jobs);
    return {1000 * garmentDistanceM(pair, now.positions, truth.positions, jobs),
            1000 * pointDistanceM(seen, still.positions, now.positions, places.at(truth.positions))};
}

TEST(PointDistance, seesSlipThatTheNearestDistanceDoesNot) {
    const Slip slip = slipOf(0.2f, 0);
    EXPECT_NEAR(slip.nearestMm, 0, 1e-3);
    EXPECT_NEAR(slip.pointMm, 200, 1e-2);
}

TEST(PointDistance, countsTheGapOfTheStillFramesAsTheNearestDoes) {
    EXPECT_NEAR(slipOf(0, 0.01f).pointMm, 10, 1e-2);
    EXPECT_NEAR(slipOf(0.03f, 0.04f).pointMm, 50, 1e-2);
}

TEST(PointDistance, placesAreThoseOfTheMeanOverStillFramesAndFollowTheTruth) {
    // The person sways by 2 cm and back; then the true garment moves up by 10 cm and the avatar's stays.
    Jobs jobs(2);
    const Sheet avatar = slid(sheet(1, 0), 1), truth = sheet(3, 0, 60);
    const GarmentPair pair{"top", avatar.triangles, truth.triangles, truth.triangles};
    const std::vector<Vec3f> up(avatar.positions.size(), Vec3f(0, -1, 0));
    std::vector<GarmentPlaces::Still> stills;
    for (const float sway : {0.02f, -0.02f}) stills.push_back({slid(avatar, sway).positions, up, truth.positions});
    const GarmentPlaces places(pair, stills, jobs);
    const auto mm = [&](const Sheet& now) {
        return 1000 * pointDistanceM(pair, avatar.positions, avatar.positions, places.at(now.positions));
    };
    EXPECT_NEAR(mm(truth), 0, 1e-2);
    EXPECT_NEAR(mm(sheet(3, 0.1f, 60)), 100, 1e-2);
}

TEST(PointDistance, isTheMeanOverTheAreaAtRest) {
    // Half of the area is 10 cm off, in an eighth of the triangles.
    Sheet two = sheet(1, 0, 5);
    const Sheet fine = slid(sheet(1, 0, 35), 1);
    const auto first = uint32_t(two.positions.size());
    two.positions.insert(two.positions.end(), fine.positions.begin(), fine.positions.end());
    for (const Triangle& t : fine.triangles) two.triangles.push_back(t + first);
    std::vector<Vec3f> moved = two.positions;
    for (uint32_t v = 0; v < first; ++v) moved[v].y += 0.1f;
    EXPECT_NEAR(1000 * pointDistanceM({"top", two.triangles, {}, {}}, two.positions, moved, two.positions), 50, 1e-3);
    EXPECT_EQ(pointDistanceM({"top", {}, {}, {}}, two.positions, moved, two.positions), 0);
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
