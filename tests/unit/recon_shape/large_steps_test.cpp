// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/shape/large_steps.h"

#include <gtest/gtest.h>

#include <random>

namespace dpl {
namespace {

struct Grid {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
};

Grid grid(uint32_t side, float step = 0.01f, Vec3f origin = Vec3f(0)) {
    Grid g;
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) g.positions.push_back(origin + step * Vec3f(x, y, 0.1f * float(x * y % 3)));
    for (uint32_t y = 0; y + 1 < side; ++y)
        for (uint32_t x = 0; x + 1 < side; ++x) {
            const uint32_t a = y * side + x;
            g.triangles.push_back({a, a + 1, a + side});
            g.triangles.push_back({a + 1, a + side + 1, a + side});
        }
    return g;
}

void append(Grid& to, const Grid& from) {
    const uint32_t first = uint32_t(to.positions.size());
    to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
    for (Triangle t : from.triangles) to.triangles.push_back(t + first);
}

std::vector<Vec3d> noise(size_t count, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Vec3d> x(count);
    for (Vec3d& v : x) v = {normal(random), normal(random), normal(random)};
    return x;
}

TEST(LargeSteps, residualBelowOneInAMillionUpToLambdaOneMillion) {
    const Grid g = grid(40);
    for (double lambda : {1.0, 19.0, 1e3, 1e4, 1e6}) {
        auto steps = LargeSteps::createWithLambda(g.positions, g.triangles, lambda);
        ASSERT_TRUE(steps) << steps.error().message;
        const auto b = noise(steps->size(), 1);
        auto x = b;
        steps->solve(x);
        std::vector<Vec3d> back(x.size());
        steps->apply(x, back);
        double worst = 0;
        for (size_t i = 0; i < b.size(); ++i) worst = std::max(worst, glm::length(back[i] - b[i]));
        EXPECT_LT(worst, 1e-6) << "lambda " << lambda;
    }
}

TEST(LargeSteps, backwardIsTheTransposeOfForward) {
    Grid g = grid(12);
    append(g, grid(7, 0.02f, {1, 0, 0}));
    for (const uint32_t held : {0u, 1u, uint32_t(g.positions.size())}) {
        auto steps = LargeSteps::create(g.positions, g.triangles, 0.04);
        ASSERT_TRUE(steps);
        const auto a = noise(steps->size(), 2), b = noise(g.positions.size(), 3);
        std::vector<Vec3f> u(a.begin(), a.end()), w(b.begin(), b.end()), forward(g.positions.size()), back(steps->size());
        steps->offsets(u, forward, held);
        steps->backward(w, back, held);
        double left = 0, right = 0;
        for (size_t v = 0; v < w.size(); ++v) left += glm::dot(Vec3d(forward[v]), Vec3d(w[v]));
        for (size_t i = 0; i < u.size(); ++i) right += glm::dot(Vec3d(u[i]), Vec3d(back[i]));
        EXPECT_GT(std::abs(left), 1e-3);
        EXPECT_NEAR(left, right, 1e-4 * std::abs(left)) << "float in and out";
    }
}

TEST(LargeSteps, disconnectedPartsDoNotAffectEachOtherAndOnlyHeldPartsLoseTheirMean) {
    Grid g = grid(6);
    const size_t first = g.positions.size();
    append(g, grid(6, 0.01f, {0.5f, 0, 0}));
    auto steps = LargeSteps::createWithLambda(g.positions, g.triangles, 1000);
    ASSERT_TRUE(steps);
    EXPECT_EQ(steps->componentCount(), 2u);
    std::vector<Vec3f> u(steps->size(), Vec3f(0)), out(g.positions.size());
    u[3] = {1, 2, 3};
    steps->offsets(u, out, 0);
    for (size_t v = first; v < out.size(); ++v) EXPECT_EQ(out[v], Vec3f(0));
    EXPECT_GT(glm::length(out[0]), 0);
    std::fill(u.begin(), u.end(), Vec3f(1, 2, 3));  // both parts move as a whole
    steps->offsets(u, out, uint32_t(first));
    for (size_t v = 0; v < first; ++v) EXPECT_LT(glm::length(out[v]), 1e-5) << "the held part keeps its place";
    for (size_t v = first; v < out.size(); ++v) EXPECT_LT(glm::length(out[v] - Vec3f(1, 2, 3)), 1e-5) << "the other part is free";
}

TEST(LargeSteps, duplicateVerticesOfASeamMoveTogether) {
    Grid g = grid(8);
    append(g, grid(8, 0.01f, {0.07f, 0, 0}));  // its first column has the same positions as the last column of the first grid
    for (size_t v = 0; v < 64; ++v) {
        g.positions[v].z = 0;
        g.positions[64 + v].z = 0;
        g.positions[64 + v].x = float((v % 8) + 7) * 0.01f;  // equal positions need bit-equal floats
        g.positions[v].x = float(v % 8) * 0.01f;
    }
    auto steps = LargeSteps::createWithLambda(g.positions, g.triangles, 50);
    ASSERT_TRUE(steps);
    EXPECT_EQ(steps->size(), 64u + 64u - 8u);
    EXPECT_EQ(steps->componentCount(), 1u);
    const auto a = noise(steps->size(), 5);
    std::vector<Vec3f> u(a.begin(), a.end()), out(g.positions.size());
    steps->offsets(u, out, 0);
    for (size_t y = 0; y < 8; ++y) EXPECT_EQ(out[y * 8 + 7], out[64 + y * 8]);
}

TEST(LargeSteps, lambdaFollowsTheSmoothingLength) {
    const Grid coarse = grid(10, 0.02f), fine = grid(19, 0.01f);
    auto a = LargeSteps::create(coarse.positions, coarse.triangles, 0.04), b = LargeSteps::create(fine.positions, fine.triangles, 0.04);
    ASSERT_TRUE(a && b);
    EXPECT_NEAR(b->lambda() / a->lambda(), 4, 0.2)
        << "half the edge length needs four times the λ; the grid's relief does not scale exactly";
}

TEST(LargeSteps, refusesWhatItCannotFactor) {
    Grid g = grid(3);
    g.triangles.push_back({0, 1, 99});
    EXPECT_FALSE(LargeSteps::create(g.positions, g.triangles, 0.04));
    g.triangles.pop_back();
    g.positions[2].x = NAN;
    EXPECT_FALSE(LargeSteps::createWithLambda(g.positions, g.triangles, 1));
    EXPECT_FALSE(LargeSteps::createWithLambda(grid(3).positions, grid(3).triangles, -1));
}

}  // namespace
}  // namespace dpl
