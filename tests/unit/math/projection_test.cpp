// SPDX-License-Identifier: Apache-2.0
// The screen footprint, its determinant, the gate and the near fade.
#include "sdk/math/projection.h"

#include <gtest/gtest.h>

#include <random>

namespace dpl {
namespace {

Camerad camera() {
    Camerad c;
    c.widthPx = 640, c.heightPx = 480, c.fx = 800, c.fy = 780, c.cx = 310, c.cy = 250;
    return c;
}

TEST(Projection, sumFormKeepsTheDeterminantOfNeedlesInFloat) {
    // Minor axis 0.3 px, major axis up to 2000 px: in float a·c − b² is wrong by up to 83 % (docs/reference/footprint.md).
    const Camerad d = camera();
    const Cameraf f = d.cast<float>();
    std::mt19937 random(4);
    std::uniform_real_distribution<double> angle(0, 6.283185);
    for (const double majorPx : {50.0, 200.0, 800.0, 2000.0})
        for (int i = 0; i < 100; ++i) {
            const double a = angle(random), z = 2, major = majorPx * z / d.fx, minor = 0.3 * z / d.fx;
            const Vec3d centre(0.1, -0.05, z), axis1 = major * Vec3d(std::cos(a), std::sin(a), 0.3),
                                               axis2 = minor * Vec3d(-std::sin(a), std::cos(a), 0);
            const Footprint<double> exact = projectSplat(lensOf(d), centre, axis1, axis2, kKappaPx2);
            const Footprint<float> fast = projectSplat(lensOf(f), Vec3f(centre), Vec3f(axis1), Vec3f(axis2), float(kKappaPx2));
            ASSERT_TRUE(exact.visible && fast.visible);
            EXPECT_NEAR(fast.conicA / exact.conicA, 1, 5e-5) << majorPx;
            EXPECT_NEAR(fast.conicC / exact.conicC, 1, 5e-5) << majorPx;
            EXPECT_NEAR(fast.compensation / exact.compensation, 1, 5e-4) << majorPx;  // det(B) is a difference and loses digits
        }
}

TEST(Projection, floatAgreesWithDoubleOnOrdinarySplats) {
    const Camerad d = camera();
    const Cameraf f = d.cast<float>();
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    int visible = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vec3d centre(0.5 * normal(random), 0.5 * normal(random), 1.5 + normal(random));
        const Vec3d axis1 = 0.01 * Vec3d(normal(random), normal(random), normal(random)),
                    axis2 = 0.01 * Vec3d(normal(random), normal(random), normal(random));
        const Footprint<double> exact = projectSplat(lensOf(d), centre, axis1, axis2, kKappaPx2);
        const Footprint<float> fast = projectSplat(lensOf(f), Vec3f(centre), Vec3f(axis1), Vec3f(axis2), float(kKappaPx2));
        ASSERT_EQ(exact.visible, fast.visible);
        if (!exact.visible) continue;
        ++visible;
        const double spread = std::sqrt(std::max(exact.varianceX, exact.varianceY));
        EXPECT_LT(glm::length(Vec2d(fast.centrePx) - exact.centrePx), 1e-6 * (glm::length(exact.centrePx) + 1000));
        EXPECT_NEAR(fast.varianceX, exact.varianceX, 1e-5 * spread * spread);
        EXPECT_NEAR(fast.conicA, exact.conicA, 1e-4 * exact.conicA);
        EXPECT_NEAR(fast.conicC, exact.conicC, 1e-4 * exact.conicC);
    }
    EXPECT_GT(visible, 800);
}

TEST(Projection, conicIsTheInverseOfTheVariance) {
    const Camerad c = camera();
    const Footprint<double> f = projectSplat(lensOf(c), Vec3d(0.2, 0.1, 2), Vec3d(0.02, 0.01, 0.005), Vec3d(-0.003, 0.01, 0.01), kKappaPx2);
    // A·Σxx + B·Σxy = 1 with Σxy = −B·det, det = (Σxx)/C.
    const double det = f.varianceX / f.conicC, covariance = -f.conicB * det;
    EXPECT_NEAR(f.conicA * f.varianceX + f.conicB * covariance, 1, 1e-12);
    EXPECT_NEAR(f.conicB * f.varianceX + f.conicC * covariance, 0, 1e-12);
}

TEST(Projection, nothingAtOrBehindTheNearPlane) {
    const Camerad c = camera();
    for (const double z : {-1.0, 0.0, kNearM})
        EXPECT_FALSE(projectSplat(lensOf(c), Vec3d(0, 0, z), Vec3d(0.01, 0, 0), Vec3d(0, 0.01, 0), kKappaPx2).visible);
    EXPECT_EQ(nearFade(kNearM), 0);
    EXPECT_EQ(nearFade(kNearFadeEndM), 1);
    EXPECT_NEAR(nearFade(0.5 * (kNearM + kNearFadeEndM)), 0.5, 1e-12);
}

TEST(Projection, slopeIsClampedThirtyPercentOutside) {
    const Camerad c = camera();
    const JacobianClamp<double> limit(c);
    EXPECT_NEAR(limit.maxX, (640 - 310) / 800.0 + 0.3 * 320 / 800.0, 1e-12);
    EXPECT_NEAR(limit.minX, -310 / 800.0 - 0.3 * 320 / 800.0, 1e-12);
    EXPECT_NEAR(limit.maxY, (480 - 250) / 780.0 + 0.3 * 240 / 780.0, 1e-12);
    EXPECT_NEAR(limit.minY, -250 / 780.0 - 0.3 * 240 / 780.0, 1e-12);
}

TEST(Projection, gateIsZeroFromBehindAndFullAboveATenth) {
    const Vec3d normal(0, 0, 1), centre(0);
    EXPECT_EQ(singleFaceGate(normal, centre, Vec3d(0, 0.1, -1)), 0);
    EXPECT_EQ(singleFaceGate(normal, centre, Vec3d(1, 0, 0)), 0);
    EXPECT_EQ(singleFaceGate(normal, centre, Vec3d(0, 0, 2)), 1);
    EXPECT_NEAR(singleFaceGate(normal, centre, Vec3d(std::sqrt(1 - 0.05 * 0.05), 0, 0.05)), 0.5, 1e-12);
}

TEST(Projection, visibleRadiusIsWhereAlphaMeetsTheCutOff) {
    const double q = visibleRadius2(0.7);
    EXPECT_NEAR(0.7 * std::exp(-q / 2), kMinAlpha, 1e-15);
    EXPECT_LT(visibleRadius2(0.003), 0);
}

TEST(Camera, scalingKeepsRays) {
    const Camerad c = camera(), half = c.scaled(0.5);
    EXPECT_EQ(half.widthPx, 320u);
    const Vec3d p(0.3, -0.2, 2);
    const Vec2d full = c.pixelOf(p), small = half.pixelOf(p);
    EXPECT_NEAR(small.x, full.x / 2, 1e-12);
    EXPECT_NEAR(small.y, full.y / 2, 1e-12);
}

}  // namespace
}  // namespace dpl
