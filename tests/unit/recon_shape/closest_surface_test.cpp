// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/shape/closest_surface.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "reconstruction/subject/shape/closest_leaf.h"
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

/** The closest point of a triangle in double: the least of the plane's foot point, if it lies inside, and of the three edges. */
double exactDistance(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d n = glm::normalize(glm::cross(b - a, c - a)), foot = p - glm::dot(p - a, n) * n;
    const auto side = [&](const Vec3d& from, const Vec3d& to) { return glm::dot(glm::cross(to - from, foot - from), n) >= 0; };
    if (side(a, b) && side(b, c) && side(c, a)) return std::abs(glm::dot(p - a, n));
    const auto toEdge = [&](const Vec3d& from, const Vec3d& to) {
        const double along = std::clamp(glm::dot(p - from, to - from) / glm::dot(to - from, to - from), 0.0, 1.0);
        return glm::length(p - from - along * (to - from));
    };
    return std::min({toEdge(a, b), toEdge(b, c), toEdge(c, a)});
}

TEST(ClosestSurface, everyLaneOfALeafIsExactInEveryRegion) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> in(-1, 1);
    const auto point = [&] { return Vec3f(in(random), in(random), in(random)); };
    int regions[7] = {};  // inside, three edges, three corners
    for (uint32_t lane = 0; lane < kLeafTriangles; ++lane) {
        for (int i = 0; i < 400; ++i) {
            ClosestLeaf leaf;
            const Vec3f corners[3] = {point(), point(), point()}, p = 1.5f * point();
            for (int c = 0; c < 3; ++c)
                for (int axis = 0; axis < 3; ++axis) leaf.corner[c][axis][lane] = corners[c][axis];
            LeafPoints found;
            closestInLeaf(leaf, p, found);
            const Vec3f w(found.weight[0][lane], found.weight[1][lane], found.weight[2][lane]);
            EXPECT_NEAR(std::sqrt(found.distance2[lane]), exactDistance(Vec3d(p), Vec3d(corners[0]), Vec3d(corners[1]), Vec3d(corners[2])),
                        2e-6);  // of coordinates up to 1.5, in float
            EXPECT_NEAR(w.x + w.y + w.z, 1, 1e-6);
            const int zeros = (w.x == 0) + (w.y == 0) + (w.z == 0);
            ++regions[zeros == 0 ? 0 : zeros == 1 ? (w.x == 0 ? 1 : w.y == 0 ? 2 : 3) : (w.x != 0 ? 4 : w.y != 0 ? 5 : 6)];
        }
        ClosestLeaf point0;  // a triangle without area at the origin
        LeafPoints found;
        closestInLeaf(point0, {0, 3, 4}, found);
        EXPECT_EQ(found.distance2[lane], 25);
        EXPECT_EQ(found.weight[0][lane], 1);
    }
    for (const int count : regions) EXPECT_GT(count, 40);
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
