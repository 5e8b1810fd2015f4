// SPDX-License-Identifier: Apache-2.0
// The binding of splats to triangles: deformation gradient, polar rotation, and which triangles are refused.
#include "sdk/math/binding.h"

#include <gtest/gtest.h>

#include <random>

namespace dpl {
namespace {

struct Case {
    Vec3d rest[3], posed[3];
};

Case randomCase(std::mt19937& random) {
    std::normal_distribution<double> normal;
    Case c;
    for (Vec3d& p : c.rest) p = 0.05 * Vec3d(normal(random), normal(random), normal(random));
    for (Vec3d& p : c.posed) p = 0.05 * Vec3d(normal(random), normal(random), normal(random));
    return c;
}

template <class T>
TriangleFrame<T> frameOf(const Case& c) {
    return poseTriangle(restTriangle(Vec3<T>(c.rest[0]), Vec3<T>(c.rest[1]), Vec3<T>(c.rest[2])), Vec3<T>(c.posed[0]), Vec3<T>(c.posed[1]),
                        Vec3<T>(c.posed[2]));
}

TEST(Binding, deformationGradientTakesRestEdgesToPosedEdges) {
    std::mt19937 random(1);
    int compared = 0;
    for (int i = 0; i < 200; ++i) {
        const Case c = randomCase(random);
        const RestTriangle<double> rest = restTriangle(c.rest[0], c.rest[1], c.rest[2]);
        const TriangleFrame<double> f = frameOf<double>(c);
        if (!f.valid) continue;
        ++compared;
        for (int edge = 1; edge <= 2; ++edge) {
            const Vec3d e = c.rest[edge] - c.rest[0];
            const Vec3d moved = glm::dot(e, rest.frame[0]) * f.f0 + glm::dot(e, rest.frame[1]) * f.f1;
            EXPECT_LT(glm::length(moved - (c.posed[edge] - c.posed[0])), 1e-12);  // double, 5 cm edges, slivers included
        }
    }
    EXPECT_GT(compared, 180);
}

TEST(Binding, polarRotationLeavesASymmetricPositiveStretch) {
    std::mt19937 random(2);
    int compared = 0;
    for (int i = 0; i < 200; ++i) {
        const Case c = randomCase(random);
        const RestTriangle<double> rest = restTriangle(c.rest[0], c.rest[1], c.rest[2]);
        const TriangleFrame<double> f = frameOf<double>(c);
        if (!f.valid) continue;
        ++compared;
        EXPECT_NEAR(glm::determinant(f.worldFromRest), 1, 1e-12);
        const Mat3d stretch = glm::transpose(f.worldFromRest) * Mat3d(f.f0, f.f1, f.normal) * glm::transpose(rest.frame);
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < a; ++b) EXPECT_NEAR(stretch[a][b], stretch[b][a], 1e-11 * glm::length(f.f0));
        EXPECT_GT(glm::determinant(stretch), 0);
        EXPECT_GT(stretch[0][0] + stretch[1][1] + stretch[2][2], 0);
    }
    EXPECT_GT(compared, 180);
}

TEST(Binding, rigidMotionIsItsOwnPolarRotation) {
    const Mat3d turn = glm::mat3_cast(glm::normalize(Quatd(0.3, -0.5, 0.7, 0.2)));
    Case c;
    c.rest[0] = {0, 0, 0}, c.rest[1] = {0.1, 0.02, 0}, c.rest[2] = {0.01, 0.09, 0.03};
    for (int k = 0; k < 3; ++k) c.posed[k] = turn * c.rest[k] + Vec3d(3, 2, 1);
    const TriangleFrame<double> f = frameOf<double>(c);
    for (int k = 0; k < 3; ++k) EXPECT_LT(glm::length(f.worldFromRest[k] - turn[k]), 1e-12);
}

TEST(Binding, floatAgreesWithDouble) {
    std::mt19937 random(3);
    int compared = 0;
    for (int i = 0; i < 300; ++i) {
        const Case c = randomCase(random);
        const TriangleFrame<double> d = frameOf<double>(c);
        const TriangleFrame<float> f = frameOf<float>(c);
        const double sine = glm::length(glm::cross(c.rest[1] - c.rest[0], c.rest[2] - c.rest[0])) /
                            (glm::length(c.rest[1] - c.rest[0]) * glm::length(c.rest[2] - c.rest[0]));
        if (!d.valid || !f.valid || sine < 0.1) continue;  // slivers amplify rounding by 1/sine
        ++compared;
        Vec3d axis1, axis2;
        Vec3f axis1f, axis2f;
        splatAxes(d, 0.7, 0.01, 0.002, axis1, axis2);
        splatAxes(f, 0.7f, 0.01f, 0.002f, axis1f, axis2f);
        const double size = glm::length(axis1) + glm::length(axis2);
        EXPECT_LT(glm::length(Vec3d(axis1f) - axis1), 1e-5 * size);  // 24 bits, a dozen operations, 1/sine ≤ 10
        EXPECT_LT(glm::length(Vec3d(axis2f) - axis2), 1e-5 * size);
    }
    EXPECT_GT(compared, 200);
}

TEST(Binding, degenerateTrianglesAreRefused) {
    const Vec3d o(0), x(0.1, 0, 0), y(0, 0.1, 0);
    const RestTriangle<double> good = restTriangle(o, x, y);
    EXPECT_TRUE(good.valid);
    EXPECT_FALSE(restTriangle(o, x, x).valid);
    EXPECT_FALSE(restTriangle(o, o, o).valid);
    EXPECT_FALSE(restTriangle(o, Vec3d(1e-5, 0, 0), Vec3d(0, 1e-5, 0)).valid);  // 5e-11 m²
    EXPECT_FALSE(restTriangle(o, Vec3d(NAN, 0, 0), y).valid);
    EXPECT_TRUE(poseTriangle(good, o, x, y).valid);
    EXPECT_FALSE(poseTriangle(good, o, x, 2.0 * x).valid);
    EXPECT_FALSE(poseTriangle(good, o, Vec3d(1, 0, 0), Vec3d(0.5, 0.9e-4, 0)).valid);  // aspect 1.1e4
    EXPECT_TRUE(poseTriangle(good, o, Vec3d(1, 0, 0), Vec3d(0.5, 1.1e-4, 0)).valid);   // aspect 9e3
    EXPECT_FALSE(poseTriangle(good, o, Vec3d(NAN, 0, 0), y).valid);
    EXPECT_FALSE(poseTriangle(RestTriangle<double>{}, o, x, y).valid);
}

/** A triangle of 5 cm whose F has two singular values, turned and moved. */
Case stretchedCase(std::mt19937& random, double largest, double smallest) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    Case c;
    c.rest[0] = {0, 0, 0}, c.rest[1] = {0.05, 0.01, 0}, c.rest[2] = {0.01, 0.04, 0.02};
    const RestTriangle<double> rest = restTriangle(c.rest[0], c.rest[1], c.rest[2]);
    const double angle = 3 * uniform(random);
    const Vec3d along = std::cos(angle) * rest.frame[0] + std::sin(angle) * rest.frame[1],
                across = std::cos(angle) * rest.frame[1] - std::sin(angle) * rest.frame[0];
    const Mat3d turn = glm::mat3_cast(glm::normalize(Quatd(uniform(random), uniform(random), uniform(random), uniform(random))));
    for (int k = 0; k < 3; ++k)
        c.posed[k] =
            turn * (largest * glm::dot(c.rest[k], along) * along + smallest * glm::dot(c.rest[k], across) * across) + Vec3d(0.3, 1, -0.2);
    return c;
}

/** Singular values of [f0 f1], larger first. */
std::pair<double, double> singularValues(const Vec3d& f0, const Vec3d& f1) {
    const double p = glm::dot(f0, f0), q = glm::dot(f0, f1), r = glm::dot(f1, f1), gap = std::hypot(0.5 * (p - r), q);
    return {std::sqrt(0.5 * (p + r) + gap), glm::length(glm::cross(f0, f1)) / std::sqrt(0.5 * (p + r) + gap)};
}

template <class T>
TriangleFrame<T> drawnOf(const Case& c) {
    return drawnTriangle(restTriangle(Vec3<T>(c.rest[0]), Vec3<T>(c.rest[1]), Vec3<T>(c.rest[2])), Vec3<T>(c.posed[0]), Vec3<T>(c.posed[1]),
                         Vec3<T>(c.posed[2]));
}

TEST(Binding, aTriangleWithinTheBoundsKeepsItsBits) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> within(kStretchLow + 1e-6, kStretchHigh - 1e-6);
    for (int i = 0; i < 1000; ++i) {
        const double a = within(random), b = within(random);
        const Case c = stretchedCase(random, std::max(a, b), std::min(a, b));
        const TriangleFrame<float> plain = frameOf<float>(c), drawn = drawnOf<float>(c);
        ASSERT_TRUE(drawn.valid);
        EXPECT_TRUE(drawn.f0 == plain.f0 && drawn.f1 == plain.f1 && drawn.worldFromRest == plain.worldFromRest);
        EXPECT_EQ(drawn.shown, 1.0f);
        EXPECT_FALSE(drawn.bounded);
    }
}

TEST(Binding, stretchIsBoundedAndContinuous) {
    std::mt19937 random(5);
    double before = 0;
    for (double stretch = 0.02; stretch < 5; stretch += 0.01) {
        const Case c = stretchedCase(random, std::max(stretch, 0.9), std::min(stretch, 0.9));
        const TriangleFrame<double> f = drawnOf<double>(c);
        if (stretch > kStretchGone) {
            EXPECT_FALSE(f.valid) << stretch;
            continue;
        }
        ASSERT_TRUE(f.valid) << stretch;
        const auto [largest, smallest] = singularValues(f.f0, f.f1);
        const double drawn = stretch > 0.9 ? largest : smallest;
        EXPECT_LE(largest, kStretchHigh + kStretchHighRoom);
        EXPECT_GE(smallest, kStretchLow - kStretchLowRoom);
        EXPECT_NEAR(stretch > 0.9 ? smallest : largest, 0.9, 1e-9) << "the other singular value stays";
        if (before > 0) {
            EXPECT_GT(drawn, before) << stretch;
            EXPECT_LT(drawn - before, 0.01 + 1e-9) << stretch;
        }
        before = drawn;
        EXPECT_EQ(f.shown<1, stretch> kStretchFade || stretch < kSqueezeFade) << stretch;
        EXPECT_LT(glm::length(f.worldFromRest[0] - frameOf<double>(c).worldFromRest[0]), 1e-12) << "colours turn as before";
    }
}

TEST(Binding, stretchIsMeasuredFromTheRestOfNow) {
    // Training has made the triangle twice as long as the one that splat sizes refer to. Posed as it now rests, it is not stretched.
    const Vec3d o(0), x(0.05, 0, 0), y(0, 0.05, 0);
    const RestTriangle<double> bind = restTriangle(o, x, y), now = restTriangle(o, 2.0 * x, y);
    const TriangleFrame<double> still = drawnTriangle(bind, now, o, 2.0 * x, y);
    EXPECT_FALSE(still.bounded);
    EXPECT_NEAR(glm::length(still.f0), 2, 1e-12);
    // Sheared and stretched 2.5 times more: the same as if splat sizes referred to the rest of now.
    const Vec3d v1 = 5.0 * x, v2 = y + 0.02 * Vec3d(1, 0, 1);
    const TriangleFrame<double> drawn = drawnTriangle(bind, now, o, v1, v2), direct = drawnTriangle(now, o, v1, v2);
    EXPECT_TRUE(drawn.bounded && direct.bounded);
    EXPECT_EQ(drawn.shown, direct.shown);
    EXPECT_LT(glm::length(drawn.f0 - 2.0 * direct.f0), 1e-12);
    EXPECT_LT(glm::length(drawn.f1 - direct.f1), 1e-12);
    EXPECT_TRUE(drawnTriangle(bind, RestTriangle<double>{}, o, 2.0 * x, y).bounded) << "where the rest of now is degenerate, that of bind";
}

TEST(Binding, wildCornersGiveFiniteFramesOrNone) {
    const RestTriangle<float> rest = restTriangle(Vec3f(0), Vec3f(0.05f, 0, 0), Vec3f(0, 0.05f, 0));
    const float wild[] = {0, 1e-30f, 1e-4f, 0.05f, 1e3f, 1e18f, 3e38f, -3e38f, INFINITY, NAN};
    for (const float a : wild)
        for (const float b : wild)
            for (const float c : wild) {
                const TriangleFrame<float> f = drawnTriangle(rest, Vec3f(0), Vec3f(a, 0, b), Vec3f(c, b, 0.01f));
                if (!f.valid) continue;
                for (const float x : {f.f0.x, f.f0.y, f.f0.z, f.f1.x, f.f1.y, f.f1.z, f.shown}) EXPECT_TRUE(std::isfinite(x));
                EXPECT_TRUE(f.shown > 0 && f.shown <= 1);
            }
}

TEST(Binding, invertedTriangleHasAReversedNormal) {
    const Vec3d o(0), x(0.1, 0, 0), y(0, 0.1, 0);
    EXPECT_NEAR(poseTriangle(restTriangle(o, x, y), o, y, x).normal.z, -1, 1e-12);
}

}  // namespace
}  // namespace dpl
