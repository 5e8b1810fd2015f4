// SPDX-License-Identifier: Apache-2.0
#include "sdk/surface/ray_caster.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/not_finite.h"
#include "tests/unit/ball_mesh.h"

namespace dpl::test {
namespace {

/** A ball of radius 1 about the origin, on five joints around it. */
MeshData ball(uint32_t rings) {
    MeshData m = ballMesh(rings, 2 * rings, 1);
    for (size_t v = 0; v < m.restPositions.size(); ++v) {
        const float turn = std::atan2(m.restPositions[v].x, m.restPositions[v].z) / float(2 * M_PI) + 0.5f;
        m.jointIndices[v] = glm::u16vec4(std::min(4, int(5 * turn)), 0, 0, 0);
        m.jointWeights[v] = glm::u8vec4(255, 0, 0, 0);
    }
    return m;
}

/** The nearest triangle by Möller and Trumbore, in double precision and through all of them. */
std::optional<RayHit> bruteForce(const MeshData& m, std::span<const Vec3f> at, const SurfaceRay& ray,
                                 std::span<const uint8_t> leftOut = {}) {
    std::optional<RayHit> nearest;
    for (uint32_t t = 0; t < m.triangles.size(); ++t) {
        if (!leftOut.empty() && leftOut[t]) continue;
        const Vec3d a(at[m.triangles[t].x]), e1 = Vec3d(at[m.triangles[t].y]) - a, e2 = Vec3d(at[m.triangles[t].z]) - a;
        const Vec3d p = glm::cross(ray.direction, e2), s = ray.origin - a, q = glm::cross(s, e1);
        const double det = glm::dot(e1, p);
        if (std::abs(det) < 1e-14) continue;
        const double u = glm::dot(s, p) / det, v = glm::dot(ray.direction, q) / det, distance = glm::dot(e2, q) / det;
        if (u < 0 || v < 0 || u + v > 1 || distance < 0 || (nearest && distance >= nearest->distanceM)) continue;
        nearest = RayHit{distance, t, {1 - u - v, u, v}};
    }
    return nearest;
}

Vec3d pointOf(const MeshData& m, std::span<const Vec3f> at, const RayHit& hit) {
    const Triangle& t = m.triangles[hit.triangle];
    return hit.shares.x * Vec3d(at[t.x]) + hit.shares.y * Vec3d(at[t.y]) + hit.shares.z * Vec3d(at[t.z]);
}

TEST(RayCasterTest, meetsWhatAllTrianglesOneByOneDo) {
    const MeshData m = ball(24);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<Vec3f> posed = m.restPositions;
    for (Vec3f& p : posed) p += Vec3f(0.1f * float(normal(random)), 0.3f * p.x, 0);
    RayCaster caster(m);
    caster.follow(posed);
    const auto any = [&](double size) { return size * Vec3d(normal(random), normal(random), normal(random)); };
    uint32_t met = 0;
    for (uint32_t i = 0; i < 4000; ++i) {
        const SurfaceRay ray{any(i % 2 ? 2.0 : 0.3), glm::normalize(any(1))};  // from without, and from within
        const auto fast = caster.cast(posed, ray), slow = bruteForce(m, posed, ray);
        ASSERT_EQ(bool(fast), bool(slow)) << i;
        if (!fast) continue;
        ++met;
        EXPECT_NEAR(fast->distanceM, slow->distanceM, 1e-9) << i;
        EXPECT_LT(glm::distance(pointOf(m, posed, *fast), ray.origin + fast->distanceM * ray.direction), 1e-9) << i;
    }
    EXPECT_GT(met, 2000u);
    EXPECT_LT(met, 3900u);
}

TEST(RayCasterTest, slipsThroughNoEdgeOrCorner) {
    const MeshData m = ball(16);
    RayCaster caster(m);
    caster.follow(m.restPositions);
    for (const Triangle& t : m.triangles)
        for (const Vec3f& at : {m.restPositions[t.x], 0.5f * (m.restPositions[t.x] + m.restPositions[t.y]),
                                0.25f * m.restPositions[t.y] + 0.75f * m.restPositions[t.z]}) {
            const Vec3d to(at);
            const auto hit = caster.cast(m.restPositions, {3.0 * to, -glm::normalize(to)});
            ASSERT_TRUE(hit);
            EXPECT_NEAR(hit->distanceM, 2 * glm::length(to), 1e-6);
            EXPECT_TRUE(caster.cast(m.restPositions, {Vec3d(0), glm::normalize(to)}));
        }
    // Along an axis, two components of the direction are 0.
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            Vec3d direction(0);
            direction[axis] = sign;
            const auto hit = caster.cast(m.restPositions, {-5.0 * direction, direction});
            ASSERT_TRUE(hit) << axis;
            EXPECT_NEAR(hit->distanceM, 4, 0.03);
        }
}

TEST(RayCasterTest, runsAlongAFlatMeshWithoutMeetingIt) {
    MeshData m;
    m.restPositions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    m.jointIndices.assign(3, glm::u16vec4(0)), m.jointWeights.assign(3, glm::u8vec4(255, 0, 0, 0));
    m.triangles = {{0, 1, 2}};
    RayCaster caster(m);
    caster.follow(m.restPositions);
    EXPECT_FALSE(caster.cast(m.restPositions, {{-1, 0, 0}, {1, 0, 0}}));    // along its edge
    EXPECT_FALSE(caster.cast(m.restPositions, {{0.2, -1, 0}, {0, 1, 0}}));  // in its plane
    EXPECT_TRUE(caster.cast(m.restPositions, {{0.2, 0.2, 1}, {0, 0, -1}}));
    EXPECT_FALSE(caster.cast(m.restPositions, {{0.2, 0.2, -1}, {0, 0, -1}}));  // it is behind
    EXPECT_TRUE(caster.cast(m.restPositions, {{0.2, 0.2, 0}, {0, 0, -1}}));    // it begins there
}

TEST(RayCasterTest, leavesOutWhatItIsTold) {
    const MeshData m = ball(12);
    RayCaster caster(m);
    caster.follow(m.restPositions);
    const SurfaceRay ray{{0.1, 0.2, 5}, {0, 0, -1}};
    const auto front = caster.cast(m.restPositions, ray);
    ASSERT_TRUE(front);
    std::vector<uint8_t> leftOut(m.triangles.size(), 0);
    leftOut[front->triangle] = 1;
    const auto back = caster.cast(m.restPositions, ray, leftOut), slow = bruteForce(m, m.restPositions, ray, leftOut);
    ASSERT_TRUE(back && slow);
    EXPECT_GT(back->distanceM, 5);
    EXPECT_EQ(back->triangle, slow->triangle);
    leftOut.assign(leftOut.size(), 1);
    EXPECT_FALSE(caster.cast(m.restPositions, ray, leftOut));
}

TEST(RayCasterTest, takesVerticesThatAreNotFinite) {
    MeshData m = ball(6);
    std::vector<Vec3f> posed = m.restPositions;
    posed[10] = Vec3f(kNan), posed[11].x = kInfinity;
    RayCaster caster(m);
    caster.follow(posed);
    uint32_t met = 0;
    for (int i = 0; i < 100; ++i) {
        const Vec3d from(3 * std::cos(i), 0.03 * i - 1.5, 3 * std::sin(i));
        if (const auto hit = caster.cast(posed, {from, -glm::normalize(from)})) met += std::isfinite(hit->distanceM);
    }
    EXPECT_GT(met, 50u);
}

}  // namespace
}  // namespace dpl::test
