// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics: orthonormal over the sphere, right signs, clamped colour.
#include "sdk/math/sh.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dpl {
namespace {

TEST(SphericalHarmonics, orthonormalOverTheSphere) {
    // Midpoint rule with 200 × 400 points; its error falls with 1/n².
    constexpr int kRings = 200, kSegments = 400;
    double gram[16][16] = {};
    for (int r = 0; r < kRings; ++r)
        for (int s = 0; s < kSegments; ++s) {
            const double theta = M_PI * (r + 0.5) / kRings, phi = 2 * M_PI * (s + 0.5) / kSegments;
            const Vec3d d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
            double basis[16];
            shBasis(d, 3, basis);
            const double area = std::sin(theta) * (M_PI / kRings) * (2 * M_PI / kSegments);
            for (int i = 0; i < 16; ++i)
                for (int j = 0; j < 16; ++j) gram[i][j] += basis[i] * basis[j] * area;
        }
    for (int i = 0; i < 16; ++i)
        for (int j = 0; j < 16; ++j) EXPECT_NEAR(gram[i][j], i == j ? 1 : 0, 1e-3) << i << ' ' << j;
}

TEST(SphericalHarmonics, firstBandHasTheSignsOfSplatFiles) {
    double basis[4];
    shBasis(Vec3d(1, 0, 0), 1, basis);
    EXPECT_NEAR(basis[3], -0.4886025, 1e-7);
    shBasis(Vec3d(0, 1, 0), 1, basis);
    EXPECT_NEAR(basis[1], -0.4886025, 1e-7);
    shBasis(Vec3d(0, 0, 1), 1, basis);
    EXPECT_NEAR(basis[2], 0.4886025, 1e-7);
}

TEST(SphericalHarmonics, colourIsClampedAndOffsetByHalf) {
    const float zero[3] = {0, 0, 0}, strong[3] = {10, -10, 1};
    const Vec3f grey = shColour(zero, 0, Vec3f(0, 0, 1)), clamped = shColour(strong, 0, Vec3f(0, 0, 1));
    EXPECT_EQ(grey, Vec3f(0.5f));
    EXPECT_EQ(clamped.x, 1);
    EXPECT_EQ(clamped.y, 0);
    EXPECT_NEAR(clamped.z, 0.5f + 0.28209479f, 1e-6f);
}

}  // namespace
}  // namespace dpl
