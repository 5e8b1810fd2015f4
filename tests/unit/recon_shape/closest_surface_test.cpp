// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/shape/closest_surface.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {
namespace {

SurfaceMesh ball(float radius) {
    SampleGrid grid;
    for (auto* axis : {&grid.xs, &grid.ys, &grid.zs}) appendSamples(*axis, -1.2f * radius, 1.2f * radius, radius / 12);
    Jobs jobs(1);
    return marchField([&](const Vec3f& p) { return glm::length(p) - radius; }, grid, jobs);
}

/** The closest point of a triangle by a fine search over its barycentric grid, in double. */
double distanceBySampling(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    double best = 1e30;
    constexpr int kSteps = 120;
    for (int i = 0; i <= kSteps; ++i)
        for (int j = 0; i + j <= kSteps; ++j) {
            const double u = double(i) / kSteps, v = double(j) / kSteps;
            best = std::min(best, glm::length(p - ((1 - u - v) * a + u * b + v * c)));
        }
    return best;
}

TEST(ClosestSurface, findsWhatASearchOfAllTrianglesFinds) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> in(-1, 1);
    const auto point = [&] { return Vec3f(in(random), in(random), in(random)); };
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
    for (uint32_t t = 0; t < 40; ++t) {
        const Vec3f centre = point();
        for (int k = 0; k < 3; ++k) positions.push_back(centre + 0.3f * point());
        triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    const ClosestSurface surface(positions, triangles);
    for (int i = 0; i < 30; ++i) {
        const Vec3f p = 1.3f * point();
        double best = 1e30;
        for (const Triangle& t : triangles)
            best = std::min(best, distanceBySampling(Vec3d(p), Vec3d(positions[t.x]), Vec3d(positions[t.y]), Vec3d(positions[t.z])));
        const SurfacePoint found = surface.find(p);
        ASSERT_TRUE(found.found());
        EXPECT_LE(found.distanceM, best + 1e-5);
        EXPECT_NEAR(found.distanceM, best, 0.004);  // the sampling's step
        EXPECT_NEAR(glm::length(found.position - p), found.distanceM, 1e-5);
        EXPECT_NEAR(found.barycentric.x + found.barycentric.y + found.barycentric.z, 1, 1e-5);
    }
    EXPECT_FALSE(surface.find({50, 0, 0}, 1.0f).found());
    EXPECT_FALSE(ClosestSurface({}, {}).find({0, 0, 0}).found());
}

TEST(ClosestSurface, knowsInsideFromOutside) {
    const SurfaceMesh mesh = ball(0.5f);
    const ClosestSurface surface(mesh.positions, mesh.triangles);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> in(-0.8f, 0.8f);
    for (int i = 0; i < 200; ++i) {
        const Vec3f p(in(random), in(random), in(random));
        EXPECT_NEAR(surface.signedDistance(p, 2), glm::length(p) - 0.5f, 0.01);  // the facets' error
    }
    EXPECT_TRUE(std::isinf(surface.signedDistance({3, 0, 0}, 0.1f)));
}

TEST(ClosestSurface, aMovedSurfaceIsThatOfANewTree) {
    const SurfaceMesh mesh = ball(1);
    ClosestSurface moved(mesh.positions, mesh.triangles);
    std::vector<Vec3f> bent;
    for (const Vec3f& p : mesh.positions) bent.push_back({p.x + 0.8f * p.y * p.y, 1.5f * p.y, p.z - 0.4f * p.x});
    moved.move(bent);
    const ClosestSurface fresh(bent, mesh.triangles);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> in(-2, 2);
    for (int i = 0; i < 200; ++i) {
        const Vec3f p(in(random), in(random), in(random));
        const SurfacePoint a = moved.find(p), b = fresh.find(p);
        ASSERT_EQ(a.triangle, b.triangle);
        EXPECT_EQ(a.distanceM, b.distanceM);
        EXPECT_EQ(moved.normalAt(a), fresh.normalAt(b));
        EXPECT_EQ(moved.signedDistance(p, 9), fresh.signedDistance(p, 9));
    }
}

TEST(ClosestSurface, takesOnlyTrianglesThatFaceTheWay) {
    const SurfaceMesh mesh = ball(0.5f);
    const ClosestSurface surface(mesh.positions, mesh.triangles);
    const SurfacePoint nearest = surface.find({0, 0, 0.6f}), behind = surface.findFacing({0, 0, 0.6f}, {0, 0, -1}, 0.9f);
    ASSERT_TRUE(nearest.found() && behind.found());
    EXPECT_GT(nearest.position.z, 0.45f);
    EXPECT_LT(behind.position.z, 0);
    EXPECT_GT(glm::dot(surface.normalAt(nearest), Vec3f(0, 0, 1)), 0.95f);
}

}  // namespace
}  // namespace dpl
