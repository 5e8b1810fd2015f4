// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/spatial_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace dpl {
namespace {

std::vector<Vec3f> randomPoints(size_t count) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<Vec3f> points(count);
    for (Vec3f& p : points) p = {uniform(random), 1 + uniform(random), uniform(random)};
    return points;
}

double meanStepM(const std::vector<Vec3f>& points, const std::vector<uint32_t>& order) {
    double sum = 0;
    for (size_t i = 1; i < order.size(); ++i) sum += glm::length(points[order[i]] - points[order[i - 1]]);
    return sum / double(order.size() - 1);
}

bool isPermutation(std::vector<uint32_t> order) {
    std::sort(order.begin(), order.end());
    for (uint32_t i = 0; i < order.size(); ++i)
        if (order[i] != i) return false;
    return true;
}

TEST(SpatialOrder, putsNeighboursInSpaceSideBySide) {
    std::vector<Vec3f> points = randomPoints(20000);
    std::vector<uint32_t> asGiven(points.size());
    for (uint32_t i = 0; i < points.size(); ++i) asGiven[i] = i;
    const std::vector<uint32_t> order = spatialOrder(points);
    EXPECT_TRUE(isPermutation(order));
    EXPECT_LT(meanStepM(points, order), meanStepM(points, asGiven) / 8)
        << "20,000 points in 8 m³ are 0.07 m apart; neighbours in the given order are 1.3 m apart";
    for (uint32_t i = 0; i < 100; ++i)
        points[i * 100] = Vec3f(1e30f, -1e30f, 1e9f);  // a few distant points must not spoil the order of the others
    EXPECT_LT(meanStepM(randomPoints(20000), spatialOrder(points)), meanStepM(randomPoints(20000), asGiven) / 6);
}

TEST(SpatialOrder, acceptsNanAndInfinityAndKeepsEqualPointsInTheirOrder) {
    const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
    const std::vector<Vec3f> points = {{nan, 0, 0}, {1, 1, 1}, {inf, -inf, 0}, {1, 1, 1}, {-0.0f, 0, nan}, {1, 1, 1}};
    const std::vector<uint32_t> order = spatialOrder(points);
    EXPECT_TRUE(isPermutation(order));
    std::vector<uint32_t> ones;
    for (const uint32_t i : order)
        if (points[i] == Vec3f(1, 1, 1)) ones.push_back(i);
    EXPECT_EQ(ones, (std::vector<uint32_t>{1, 3, 5}));
    EXPECT_TRUE(spatialOrder({}).empty());
}

}  // namespace
}  // namespace dpl
