// SPDX-License-Identifier: Apache-2.0
// sortSplats, rebaseSplats and packWeights. Order is deterministic; a rebased splat draws the same ellipse in any pose.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sdk/format/splat_codec.h"
#include "sdk/math/binding.h"
#include "tests/unit/format/sample_avatars.h"

namespace dpl {
namespace {

Mat3d posedCovariance(const Vec3f rest[3], const Vec3d posed[3], float phi, const Vec2f& scale) {
    const auto frame = poseTriangle(restTriangle(Vec3d(rest[0]), Vec3d(rest[1]), Vec3d(rest[2])), posed[0], posed[1], posed[2]);
    EXPECT_TRUE(frame.valid);
    Vec3d a1, a2;
    splatAxes(frame, double(phi), double(scale.x), double(scale.y), a1, a2);
    return glm::outerProduct(a1, a1) + glm::outerProduct(a2, a2);
}

double norm(const Mat3d& m) {
    return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
}

TEST(RebaseSplats, posedCovarianceIsUnchanged) {
    std::mt19937 random(7);
    auto real = [&](double low, double high) { return low + (high - low) * (random() / 4294967295.0); };
    auto corner = [&](double size) { return Vec3d(real(-size, size), real(-size, size), real(-size, size)); };
    double worst = 0;
    int cases = 0;
    while (cases < 2000) {
        AvatarData a = test::tinyAvatar();
        a.mesh.triangles = {{0, 1, 2}}, a.mesh.layers[0].triangleCount = 1;
        Vec3f oldRest[4], *newRest = a.mesh.restPositions.data();
        Vec3d posed[3];
        for (int k = 0; k < 4; ++k) oldRest[k] = Vec3f(corner(0.02)), newRest[k] = oldRest[k] + Vec3f(corner(0.01));
        for (int k = 0; k < 3; ++k) posed[k] = corner(0.03);
        auto fair = [](const auto& p0, const auto& p1, const auto& p2) {
            return glm::length(glm::cross(Vec3d(p1) - Vec3d(p0), Vec3d(p2) - Vec3d(p0))) > 4e-5;
        };
        if (!fair(oldRest[0], oldRest[1], oldRest[2]) || !fair(newRest[0], newRest[1], newRest[2]) || !fair(posed[0], posed[1], posed[2]))
            continue;
        const float phi = float(real(-4, 4));
        const Vec2f scale(float(std::exp(real(-8, -4))), float(std::exp(real(-8, -4))));
        a.splats = {};
        a.splats.triangleStart = {0, 1}, a.splats.uv = {{0.3f, 0.3f}}, a.splats.phi = {phi}, a.splats.scaleM = {scale},
        a.splats.opacity = {1}, a.splats.flags = {0}, a.splats.sh = {0, 0, 0};
        auto left = rebaseSplats(std::span(oldRest, 4), a);
        ASSERT_TRUE(left);
        ASSERT_EQ(*left, 0u);
        EXPECT_GE(a.splats.scaleM[0].x, a.splats.scaleM[0].y);
        EXPECT_GE(a.splats.phi[0], 0);
        const Mat3d before = posedCovariance(oldRest, posed, phi, scale),
                    after = posedCovariance(newRest, posed, a.splats.phi[0], a.splats.scaleM[0]);
        worst = std::max(worst, norm(after - before) / norm(before));
        ++cases;
    }
    // φ, s1, s2 are rounded to floats (6e-8 each). Poses that shrink the major axis up to some tens of times magnify the error.
    EXPECT_LT(worst, 1e-5);
    RecordProperty("worst_relative", std::to_string(worst));
    std::printf("posed covariance: worst relative change %.2e over %d cases\n", worst, cases);
}

TEST(RebaseSplats, degenerateTrianglesKeepTheirSplats) {
    AvatarData a = test::tinyAvatar();
    const std::vector<Vec3f> old = a.mesh.restPositions;
    a.mesh.restPositions[2] = a.mesh.restPositions[1];  // makes triangle 0 degenerate, not triangle 1
    auto left = rebaseSplats(old, a);
    ASSERT_TRUE(left);
    EXPECT_EQ(*left, 2u);
    EXPECT_EQ(a.splats.phi[1], 1.0f);
}

TEST(RebaseSplats, wrongLengthIsAnError) {
    AvatarData a = test::tinyAvatar();
    EXPECT_FALSE(rebaseSplats(std::span<const Vec3f>(a.mesh.restPositions).first(3), a));
}

TEST(SortSplats, ordersByTriangleThenMortonWhateverTheInputOrder) {
    AvatarData sorted = test::layeredAvatar(3, 1), shuffled = sorted;
    const uint32_t n = sorted.splats.count();
    std::vector<uint32_t> triangle(n), order(n);
    for (size_t t = 0; t + 1 < sorted.splats.triangleStart.size(); ++t)
        for (uint32_t i = sorted.splats.triangleStart[t]; i < sorted.splats.triangleStart[t + 1]; ++i)
            triangle[i] = uint32_t(t), order[i] = i;
    std::mt19937 random(11);
    for (uint32_t i = n; i-- > 1;) std::swap(order[i], order[random() % (i + 1)]);
    std::vector<uint32_t> shuffledTriangle(n);
    for (uint32_t i = 0; i < n; ++i) {
        const uint32_t from = order[i];
        shuffledTriangle[i] = triangle[from];
        shuffled.splats.uv[i] = sorted.splats.uv[from], shuffled.splats.phi[i] = sorted.splats.phi[from],
        shuffled.splats.scaleM[i] = sorted.splats.scaleM[from];
        shuffled.splats.opacity[i] = sorted.splats.opacity[from], shuffled.splats.flags[i] = sorted.splats.flags[from];
        std::copy_n(sorted.splats.sh.begin() + from * 12, 12, shuffled.splats.sh.begin() + i * 12);
    }
    auto back = sortSplats(shuffled, shuffledTriangle);
    ASSERT_TRUE(back);
    EXPECT_TRUE(shuffled.splats.triangleStart == sorted.splats.triangleStart);
    EXPECT_TRUE(shuffled.splats.uv == sorted.splats.uv);
    EXPECT_TRUE(shuffled.splats.sh == sorted.splats.sh);
    for (uint32_t i = 0; i < n; ++i) EXPECT_EQ(triangle[i], shuffledTriangle[(*back)[i]]);
}

TEST(SortSplats, theOrderOfAFileIsAlreadySorted) {
    auto decoded = decodedAvatar(test::layeredAvatar(4, 0));
    ASSERT_TRUE(decoded);
    const auto order = sortSplats(*decoded);
    for (uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
}

TEST(SortSplats, aTriangleOutOfRangeIsAnError) {
    AvatarData a = test::tinyAvatar();
    EXPECT_FALSE(sortSplats(a, std::vector<uint32_t>{0, 0, 2}));
}

TEST(PackWeights, sumsTo255AndKeepsTheLargest) {
    const std::pair<uint32_t, float> many[6] = {{4, 0.1f}, {2, 0.4f}, {4, 0.15f}, {1, 0.05f}, {0, 0.2f}, {9, 0.1f}};
    const PackedWeights p = packWeights(many);
    EXPECT_EQ(p.joints, glm::u16vec4(2, 4, 0, 9));
    EXPECT_EQ(int(p.weights.x) + p.weights.y + p.weights.z + p.weights.w, 255);
    EXPECT_GE(p.weights.x, p.weights.y);
    const std::pair<uint32_t, float> bad[2] = {{4, std::nanf("")}, {2, -1.0f}};
    EXPECT_EQ(packWeights(bad).weights, glm::u8vec4(255, 0, 0, 0));
    for (int i = 0; i < 1000; ++i) {
        std::mt19937 random{uint32_t(i)};
        const std::pair<uint32_t, float> w[4] = {
            {0, float(random() % 997)}, {1, float(random() % 997)}, {2, float(random() % 997)}, {3, 1.0f}};
        const auto q = packWeights(w);
        ASSERT_EQ(int(q.weights.x) + q.weights.y + q.weights.z + q.weights.w, 255);
    }
}

}  // namespace
}  // namespace dpl
