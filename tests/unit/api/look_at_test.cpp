// SPDX-License-Identifier: Apache-2.0
// dplCameraLookAt against a reference in double: a pixel follows from scalar products with the view direction and with the part of up that
// is perpendicular to it, and from a triple product. No rotation is built.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>

#include "sdk/include/doppel/doppel.hpp"
#include "tests/unit/api/seen_point.h"

namespace {

using Point = std::array<float, 3>;
using dpl::test::seen;
using dpl::test::Vector;

Vector operator-(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector operator*(double s, const Vector& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double determinant(const Vector& a, const Vector& b, const Vector& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}
Vector unit(const Vector& a) {
    return 1 / std::hypot(a[0], a[1], a[2]) * a;
}
Vector inDouble(const Point& p) {
    return {p[0], p[1], p[2]};
}

struct Reference {
    Vector eye, forward, up;
    double focalPx, cx, cy;

    explicit Reference(const doppel::LookAt& how)
        : eye(inDouble(how.eye)),
          forward(unit(inDouble(how.target) - eye)),
          up(unit(inDouble(how.up))),
          focalPx(0.5 * how.heightPx / std::tan(0.5 * double(how.fovYRad))),
          cx(0.5 * how.widthPx),
          cy(0.5 * how.heightPx) {
        up = unit(up - dot(up, forward) * forward);
    }
    /** As dpl::test::seen. */
    Vector seen(const Vector& world) const {
        const Vector at = world - eye;
        const double z = dot(at, forward);
        return {cx + focalPx * determinant(forward, up, at) / z, cy - focalPx * dot(at, up) / z, z};
    }
};

/** Rows of unit length, perpendicular to each other, right × down = forward: to the rounding of floats, 6e-8 an entry. */
void expectRotation(const DplCamera& camera) {
    Vector rows[3];
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) rows[row][column] = camera.viewFromWorld[4 * row + column];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(dot(rows[i], rows[j]), i == j, 3e-7) << i << ", " << j;
    EXPECT_NEAR(determinant(rows[0], rows[1], rows[2]), 1, 3e-7);
}

TEST(LookAt, anAvatarAtRestIsSeenFromItsFront) {
    const auto camera = doppel::Camera::lookAt({.eye = {0, 1, 3}, .target = {0, 1, 0}, .fovYRad = 0.8f, .widthPx = 512, .heightPx = 768});
    ASSERT_TRUE(camera) << camera.error().message;
    const float expected[12] = {1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -1, 3};  // of the programs that wrote it by hand
    for (int i = 0; i < 12; ++i) EXPECT_EQ(camera->viewFromWorld[i], expected[i]) << i;
    EXPECT_NEAR(camera->fy, 384 / std::tan(0.4), 1e-4);
    EXPECT_EQ(camera->fx, camera->fy);
    EXPECT_EQ(camera->cx, 256);
    EXPECT_EQ(camera->cy, 384);
    EXPECT_EQ(camera->widthPx, 512u);
    EXPECT_EQ(camera->heightPx, 768u);
    EXPECT_EQ(camera->structSize, sizeof(DplCamera));
    EXPECT_EQ(camera->sceneDepthM, nullptr);
}

TEST(LookAt, pixelsAreThoseOfTheReference) {
    std::mt19937 random(45);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> fov(0.02f, 2.8f);
    for (int n = 0; n < 300; ++n) {
        doppel::LookAt how{.fovYRad = fov(random), .widthPx = 1 + uint32_t(random() % 2000), .heightPx = 1 + uint32_t(random() % 2000)};
        for (Point* p : {&how.eye, &how.target, &how.up})
            for (float& x : *p) x = normal(random);
        const auto camera = doppel::Camera::lookAt(how);
        ASSERT_TRUE(camera) << camera.error().message;
        expectRotation(*camera);
        const Reference reference(how);
        const double distanceM = std::sqrt(dot(inDouble(how.target) - reference.eye, inDouble(how.target) - reference.eye));
        // Floats in the matrix move a point at this distance by some 3e-7 m for a metre of the eye's place.
        const double tolerance = 1e-6 * (1 + std::sqrt(dot(reference.eye, reference.eye)) / distanceM) * camera->fy + 1e-3;
        const Vector middle = seen(*camera, inDouble(how.target));
        EXPECT_NEAR(middle[0], 0.5 * how.widthPx, tolerance) << n;
        EXPECT_NEAR(middle[1], 0.5 * how.heightPx, tolerance) << n;
        EXPECT_NEAR(middle[2], distanceM, 1e-5) << n;
        for (const double x : {-1.0, 0.3})
            for (const double y : {-0.7, 1.0}) {  // around the target, in shares of the distance
                Vector world = inDouble(how.target);
                world[0] += 0.2 * x * distanceM, world[1] += 0.2 * y * distanceM, world[2] += 0.1 * (x + y) * distanceM;
                const Vector expected = reference.seen(world), got = seen(*camera, world);
                for (int i = 0; i < 2; ++i) EXPECT_NEAR(got[i], expected[i], 2 * tolerance) << n;
                EXPECT_NEAR(got[2], expected[2], 1e-5) << n;
            }
    }
}

/** What lies a little along `up` from the target is straight above the picture's middle, and what lies to the right is right of it. */
void expectUpright(const doppel::LookAt& how) {
    const auto camera = doppel::Camera::lookAt(how);
    ASSERT_TRUE(camera) << camera.error().message;
    expectRotation(*camera);
    const Reference reference(how);
    const Vector target = inDouble(how.target);
    const double step = 0.1 * reference.seen(target)[2];
    const Vector middle = seen(*camera, target), above = seen(*camera, target - -step * reference.up);
    const double halfX = 0.5 * how.widthPx, halfY = 0.5 * how.heightPx, px = 1e-3 * camera->fy;
    EXPECT_NEAR(middle[0], halfX, px);
    EXPECT_NEAR(middle[1], halfY, px);
    EXPECT_NEAR(above[0], halfX, px);
    EXPECT_NEAR(above[1], halfY - 0.1 * camera->fy, px);
}

TEST(LookAt, upPointsUpInThePictureInHardCasesToo) {
    const doppel::LookAt usual{.eye = {0, 1, 3}, .target = {0, 1, 0}, .fovYRad = 0.8f, .widthPx = 64, .heightPx = 48};
    auto how = usual;
    how.up = {0, -2, 0.5f};  // upside down, and not of length 1
    expectUpright(how);
    how = usual, how.eye = {0, 5, 0}, how.up = {0, 0, -1};  // straight down
    expectUpright(how);
    how.up = {1, 0, 0};
    expectUpright(how);
    how = usual, how.eye = {0, -5, 0}, how.up = {0, 0, 1};  // straight up
    expectUpright(how);
    how = usual, how.eye = {0, 1e-20f, 0}, how.target = {0, 0, 0}, how.up = {0, 0, -1};
    expectUpright(how);
    how = usual, how.eye = {1e-30f, 0, 0}, how.target = {-1e-30f, 0, 0}, how.up = {0, 1e-38f, 0};
    const auto tiny = doppel::Camera::lookAt(how);  // too small for pixels in single precision, but the axes are right
    ASSERT_TRUE(tiny) << tiny.error().message;
    const float axes[12] = {0, 0, -1, 0, 0, -1, 0, 0, -1, 0, 0, 1e-30f};
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(tiny->viewFromWorld[i], axes[i], 1e-36) << i;
    how = usual, how.target = {2e38f, -1e38f, 3e38f}, how.up = {0, 3e38f, 0};
    const auto far = doppel::Camera::lookAt(how);
    ASSERT_TRUE(far) << far.error().message;
    expectRotation(*far);
    const Vector towards = unit(inDouble(how.target) - inDouble(how.eye));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(far->viewFromWorld[8 + i], towards[i], 1e-7);
    how = usual, how.eye = {6e4f, 100, -5e4f};  // 78 km away
    how.fovYRad = 1e-3f;
    const auto distant = doppel::Camera::lookAt(how);
    ASSERT_TRUE(distant) << distant.error().message;
    expectRotation(*distant);
    for (const float sine : {1e-2f, 1e-4f, 2e-6f}) {  // nearly parallel: still a rotation, with up on the side where it is
        how = usual, how.up = {0, sine, -1};
        const auto steep = doppel::Camera::lookAt(how);
        ASSERT_TRUE(steep) << sine << ": " << steep.error().message;
        expectRotation(*steep);
        EXPECT_NEAR(steep->viewFromWorld[5], -1, 1e-6) << sine;
    }
}

TEST(LookAt, aCameraIsOneViewOfTheWrapper) {
    auto camera = doppel::Camera::lookAt({.eye = {0, 1, 3}, .target = {0, 1, 0}, .fovYRad = 0.8f, .widthPx = 8, .heightPx = 8});
    ASSERT_TRUE(camera);
    const std::span<const DplCamera> views = *camera;
    EXPECT_EQ(views.size(), 1u);
    EXPECT_EQ(views.data(), &*camera);
    EXPECT_EQ(doppel::Camera().structSize, sizeof(DplCamera));
}

TEST(LookAt, wrongInputsAreRefusedWithASentence) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
    const float eye[3] = {0, 1, 3}, target[3] = {0, 1, 0}, up[3] = {0, 1, 0}, zero[3] = {}, along[3] = {0, 0, -5};
    const float notFinite[3] = {0, kNan, 0}, endless[3] = {kInfinity, 0, 0}, far[3] = {0, 2e5f, 0};
    const float nearlyAlong[3] = {1e-8f, 0, 1};
    DplCamera camera{};
    camera.structSize = sizeof camera, camera.fx = 7;
    const auto fails = [&](DplResult result, const char* words) {
        EXPECT_EQ(result, DPL_ERROR_INVALID_ARGUMENT) << words;
        EXPECT_NE(std::strstr(dplGetLastError(), words), nullptr) << dplGetLastError();
        EXPECT_EQ(camera.fx, 7) << "outputs are written only on DPL_OK";
    };
    fails(dplCameraLookAt(nullptr, target, up, 1, 8, 8, &camera), "eye is NULL");
    fails(dplCameraLookAt(eye, nullptr, up, 1, 8, 8, &camera), "target is NULL");
    fails(dplCameraLookAt(eye, target, nullptr, 1, 8, 8, &camera), "up is NULL");
    fails(dplCameraLookAt(eye, target, up, 1, 8, 8, nullptr), "camera is NULL");
    fails(dplCameraLookAt(notFinite, target, up, 1, 8, 8, &camera), "eye is not finite");
    fails(dplCameraLookAt(eye, endless, up, 1, 8, 8, &camera), "target is not finite");
    fails(dplCameraLookAt(eye, target, notFinite, 1, 8, 8, &camera), "up is not finite");
    fails(dplCameraLookAt(eye, eye, up, 1, 8, 8, &camera), "one point, (0, 1, 3)");
    fails(dplCameraLookAt(eye, target, zero, 1, 8, 8, &camera), "up is zero");
    for (const float* parallel : {along, nearlyAlong})
        fails(dplCameraLookAt(eye, target, parallel, 1, 8, 8, &camera), "parallel to the view direction (0, 0, -1)");
    fails(dplCameraLookAt(eye, target, along, 1, 8, 8, &camera), "give (0, 1, 0)");
    fails(dplCameraLookAt(up, zero, up, 1, 8, 8, &camera), "give (0, 0, -1)");
    fails(dplCameraLookAt(far, target, up, 1, 8, 8, &camera), "from the origin");
    for (const float fov : {0.0f, -1.0f, 45.0f, float(std::numbers::pi), kNan, kInfinity})
        fails(dplCameraLookAt(eye, target, up, fov, 8, 8, &camera), "fovYRad is");
    fails(dplCameraLookAt(eye, target, up, 45, 8, 8, &camera), "179.8 degrees");
    fails(dplCameraLookAt(eye, target, up, 1e-7f, 8, 8, &camera), "focal length");
    fails(dplCameraLookAt(eye, target, up, std::numeric_limits<float>::denorm_min(), 8, 8, &camera), "focal length");
    for (const auto& [width, height] : {std::array<uint32_t, 2>{0, 8}, {8, 0}, {8193, 8}, {8, UINT32_MAX}})
        fails(dplCameraLookAt(eye, target, up, 1, width, height, &camera), "sides from 1 to 8192");
    camera.structSize = 0;
    fails(dplCameraLookAt(eye, target, up, 1, 8, 8, &camera), "structSize of camera is 0");
    const auto forgotten = doppel::Camera::lookAt({.eye = {0, 1, 3}});
    ASSERT_FALSE(forgotten);
    EXPECT_EQ(forgotten.error().code, DPL_ERROR_INVALID_ARGUMENT);
}

}  // namespace
