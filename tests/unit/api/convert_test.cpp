// SPDX-License-Identifier: Apache-2.0
// doppel_convert.h against maths written another way: points are turned by quaternion products, and pixels follow from the angles and
// matrices by their definitions, in double.
#include <doppel/doppel_convert.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "tests/unit/api/seen_point.h"

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kTolerance = 1e-6;  // relative: the outputs are floats, whose rounding is 6e-8

using dpl::test::seen;
using dpl::test::Vector;
using Quaternion = std::array<double, 4>;  // x, y, z, w

Quaternion product(const Quaternion& a, const Quaternion& b) {
    return {a[3] * b[0] + b[3] * a[0] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] + b[3] * a[1] + a[2] * b[0] - a[0] * b[2],
            a[3] * b[2] + b[3] * a[2] + a[0] * b[1] - a[1] * b[0], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

Vector turned(const Quaternion& q, const Vector& v) {
    const Quaternion r = product(product(q, {v[0], v[1], v[2], 0}), {-q[0], -q[1], -q[2], q[3]});
    return {r[0], r[1], r[2]};
}

struct Pose {
    Quaternion q{0, 0, 0, 1};
    Vector p{0, 0, 0};
    float orientation[4]{0, 0, 0, 1}, position[3]{0, 0, 0};
};

/** A unit quaternion and a position, as the floats that a caller passes and as the doubles that these floats are. */
Pose poseOf(Quaternion q, Vector p) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    Pose pose;
    for (int i = 0; i < 4; ++i) pose.orientation[i] = float(q[i] / length);
    for (int i = 0; i < 3; ++i) pose.position[i] = float(p[i]), pose.p[i] = pose.position[i];
    double floats = 0;
    for (int i = 0; i < 4; ++i) floats += double(pose.orientation[i]) * pose.orientation[i];
    for (int i = 0; i < 4; ++i) pose.q[i] = pose.orientation[i] / std::sqrt(floats);
    return pose;
}

Pose randomPose(std::mt19937& random) {
    std::normal_distribution<double> normal;
    Quaternion q;
    Vector p;
    for (double& x : q) x = normal(random);
    for (double& x : p) x = normal(random);
    return poseOf(q, p);
}

DplCamera emptyCamera() {
    DplCamera camera{};
    camera.structSize = sizeof camera;
    return camera;
}

/** The world point that an eye with this pose sees at tangents (right, up) and distance z. */
Vector worldPoint(const Pose& pose, double right, double up, double z) {
    const Vector offset = turned(pose.q, {right * z, up * z, -z});
    return {pose.p[0] + offset[0], pose.p[1] + offset[1], pose.p[2] + offset[2]};
}

TEST(Convert, edgesOfAViewByAnglesAreEdgesOfThePicture) {
    std::mt19937 random(16);
    std::uniform_real_distribution<float> angle(0.05f, 1.4f);
    for (int n = 0; n < 200; ++n) {
        const Pose pose = randomPose(random);
        float angles[4] = {-angle(random), angle(random), angle(random), -angle(random)};
        if (n % 4 == 3) angles[0] = 0.5f * angles[1];  // off-axis: both edges on one side
        DplCamera camera = emptyCamera();
        ASSERT_EQ(dplCameraFromAngles(pose.orientation, pose.position, angles, 1832, 1920, &camera), DPL_OK) << dplGetLastError();
        EXPECT_EQ(camera.widthPx, 1832u);
        EXPECT_EQ(camera.heightPx, 1920u);
        const double left = std::tan(double(angles[0])), right = std::tan(double(angles[1])), top = std::tan(double(angles[2])),
                     bottom = std::tan(double(angles[3]));
        for (const double x : {0.0, 0.3, 1.0})
            for (const double y : {0.0, 0.8, 1.0}) {
                const Vector point = worldPoint(pose, left + (right - left) * x, top + (bottom - top) * y, 2.5);
                const Vector pixel = seen(camera, point);
                // The matrix holds floats, so a tangent of 5 at 2.5 m is off by some 1e-6 m of 1832 px on up to 10 m.
                EXPECT_NEAR(pixel[0] / 1832, x, 4 * kTolerance) << n;
                EXPECT_NEAR(pixel[1] / 1920, y, 4 * kTolerance) << n;
                EXPECT_NEAR(pixel[2], 2.5, 2.5 * 4 * kTolerance) << n;
            }
    }
}

TEST(Convert, anEyeAtRestLooksAlongMinusZ) {
    const Pose pose = poseOf({0, 0, 0, 1}, {0.25, 1.5, 2});
    const float angles[4] = {-0.785398163f, 0.785398163f, 0.785398163f, -0.785398163f};
    DplCamera camera = emptyCamera();
    ASSERT_EQ(dplCameraFromAngles(pose.orientation, pose.position, angles, 100, 200, &camera), DPL_OK) << dplGetLastError();
    const float expected[12] = {1, 0, 0, -0.25f, 0, -1, 0, 1.5f, 0, 0, -1, 2};
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(camera.viewFromWorld[i], expected[i], kTolerance) << i;
    EXPECT_NEAR(camera.fx, 50, 50 * kTolerance);
    EXPECT_NEAR(camera.fy, 100, 100 * kTolerance);
    EXPECT_NEAR(camera.cx, 50, 50 * kTolerance);
    EXPECT_NEAR(camera.cy, 100, 100 * kTolerance);
    EXPECT_EQ(camera.sceneDepthM, nullptr);
}

TEST(Convert, quaternionsAreNormalised) {
    const float angles[4] = {-0.8f, 0.9f, 0.7f, -0.6f}, position[3] = {1, 2, 3};
    const float unit[4] = {0.5f, 0.5f, 0.5f, 0.5f}, tripled[4] = {1.5f, 1.5f, 1.5f, 1.5f};
    DplCamera a = emptyCamera(), b = emptyCamera();
    ASSERT_EQ(dplCameraFromAngles(unit, position, angles, 64, 64, &a), DPL_OK);
    ASSERT_EQ(dplCameraFromAngles(tripled, position, angles, 64, 64, &b), DPL_OK);
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(a.viewFromWorld[i], b.viewFromWorld[i], kTolerance);
}

/** A frustum by its edges at distance 1, as textbooks give the matrices of the graphics interfaces. */
struct Frustum {
    double left, right, top, bottom, near, far;
};

struct Convention {
    const char* name;
    double forward;  // +1: view space looks along +z
    double clipUp;   // +1: clip y points up
    bool minusOne;   // clip depth -1 to 1
    bool reversed, infinite;
};

std::array<float, 16> projectionOf(const Frustum& f, const Convention& c) {
    // Rows for X = (x, y, z, 1) with distance d = forward · z. Clip depth is a + b / d after the division by d.
    const double low = c.minusOne ? -1 : 0, high = 1;
    const double atNear = c.reversed ? high : low, atFar = c.reversed ? low : high;
    const double b = c.infinite ? f.near * (atNear - atFar) : (atNear - atFar) / (1 / f.near - 1 / f.far);
    const double a = c.infinite ? atFar : atFar - b / f.far;
    double m[4][4] = {};
    m[0][0] = 2 / (f.right - f.left);
    m[0][2] = -c.forward * (f.right + f.left) / (f.right - f.left);
    m[1][1] = c.clipUp * 2 / (f.top - f.bottom);
    m[1][2] = -c.clipUp * c.forward * (f.top + f.bottom) / (f.top - f.bottom);
    m[2][2] = c.forward * a, m[2][3] = b;
    m[3][2] = c.forward;
    std::array<float, 16> columns;
    for (size_t row = 0; row < 4; ++row)
        for (size_t column = 0; column < 4; ++column) columns[4 * column + row] = float(m[row][column]);
    return columns;
}

TEST(Convert, projectionsOfEveryConventionGiveTheSameCameraAndTheirOwnDepth) {
    const Frustum f{-0.9, 1.2, 1.1, -0.7, 0.1, 50};
    const Convention conventions[] = {
        {"OpenGL", -1, 1, true, false, false},
        {"Vulkan", -1, -1, false, false, false},
        {"Metal, visionOS", -1, 1, false, true, true},
        {"Direct3D, left-handed", 1, 1, false, false, false},
        {"Unreal", 1, 1, false, true, true},
        {"Unity on Vulkan", -1, -1, false, true, false},
        {"Vulkan, looks along +z", 1, -1, false, true, true},
        {"infinite", -1, 1, false, false, true},
        {"OpenGL, reversed", -1, 1, true, true, false},
    };
    std::mt19937 random(7);
    for (const Convention& c : conventions) {
        const Pose pose = randomPose(random);
        const auto projection = projectionOf(f, c);
        DplCamera camera = emptyCamera();
        float depth[2]{};
        ASSERT_EQ(
            dplCameraFromProjection(pose.orientation, pose.position, projection.data(),
                                    c.minusOne ? DPL_CLIP_DEPTH_MINUS_ONE_TO_ONE : DPL_CLIP_DEPTH_ZERO_TO_ONE, 640, 480, &camera, depth),
            DPL_OK)
            << c.name << dplGetLastError();
        for (const double x : {0.0, 0.4, 1.0}) {
            const Vector pixel = seen(camera, worldPoint(pose, f.left + (f.right - f.left) * x, f.top + (f.bottom - f.top) * x, 3));
            EXPECT_NEAR(pixel[0] / 640, x, 4 * kTolerance) << c.name;
            EXPECT_NEAR(pixel[1] / 480, x, 4 * kTolerance) << c.name;
        }
        for (const double z : {0.1, 0.5, 7.0, 49.0}) {
            const double share = (1 / z - (c.infinite ? 0 : 1 / f.far)) / (1 / f.near - (c.infinite ? 0 : 1 / f.far));  // 1 near, 0 far
            EXPECT_NEAR(depth[0] + depth[1] / z, c.reversed ? share : 1 - share, kTolerance) << c.name << " at " << z << " m";
        }
    }
}

TEST(Convert, depthByItsPlanesAgreesWithTheTableOfDoppelVulkan) {
    const float n = 0.1f, f = 20;
    const struct {
        float atZero, atOne, scale, offset;
    } rows[] = {{n, f, f / (f - n), -f * n / (f - n)}, {n, kInfinity, 1, -n}, {f, n, -n / (f - n), f * n / (f - n)}, {kInfinity, n, 0, n}};
    for (const auto& row : rows) {
        float depth[2]{};
        ASSERT_EQ(dplDepthFromPlanes(row.atZero, row.atOne, depth), DPL_OK) << dplGetLastError();
        EXPECT_NEAR(depth[0], row.scale, kTolerance);
        EXPECT_NEAR(depth[1], row.offset, kTolerance);
    }
}

/** Position of an engine in OpenXR's axes, by the sentence of the engine's manual: which of its axes point right, up and forward. */
Vector fromUnity(const Vector& p) {
    return {p[0], p[1], -p[2]};
}
Vector fromUnreal(const Vector& p) {
    return {p[1] / 100, p[2] / 100, -p[0] / 100};
}

TEST(Convert, leftHandedPosesCarryPointsToTheSamePlaces) {
    std::mt19937 random(3);
    for (int n = 0; n < 50; ++n) {
        for (const DplAxes axes : {DPL_AXES_UNITY, DPL_AXES_UNREAL}) {
            const double metre = axes == DPL_AXES_UNREAL ? 100 : 1;
            const auto map = axes == DPL_AXES_UNITY ? fromUnity : fromUnreal;
            const Pose pose = randomPose(random), local = randomPose(random);
            float orientation[4], position[3];
            ASSERT_EQ(dplPoseFromAxes(axes, pose.orientation, pose.position, orientation, position), DPL_OK) << dplGetLastError();
            const Quaternion q = {orientation[0], orientation[1], orientation[2], orientation[3]};
            // A quaternion rotates a vector by the same formula in either handedness.
            const Vector inEngine = turned(pose.q, {local.p[0] * metre, local.p[1] * metre, local.p[2] * metre});
            const Vector expected = map({inEngine[0] + pose.p[0], inEngine[1] + pose.p[1], inEngine[2] + pose.p[2]});
            const Vector here = turned(q, map({local.p[0] * metre, local.p[1] * metre, local.p[2] * metre}));
            for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(here[i] + position[i], expected[i], 4 * kTolerance) << "axes " << int(axes);
        }
    }
}

TEST(Convert, aYawOfUnityTurnsTheOtherWay) {
    const float yaw[4] = {0, std::sin(0.25f), 0, std::cos(0.25f)}, position[3] = {1, 2, 3};
    float orientation[4], moved[3];
    ASSERT_EQ(dplPoseFromAxes(DPL_AXES_UNITY, yaw, position, orientation, moved), DPL_OK);
    EXPECT_NEAR(orientation[1], -std::sin(0.25), kTolerance);
    EXPECT_NEAR(orientation[3], std::cos(0.25), kTolerance);
    EXPECT_EQ(moved[2], -3);
    float inPlace[4], place[3];
    std::memcpy(inPlace, yaw, sizeof yaw);
    std::memcpy(place, position, sizeof position);
    ASSERT_EQ(dplPoseFromAxes(DPL_AXES_UNITY, inPlace, place, inPlace, place), DPL_OK);
    EXPECT_EQ(std::memcmp(inPlace, orientation, sizeof inPlace), 0);
    EXPECT_EQ(std::memcmp(place, moved, sizeof place), 0);
}

TEST(Convert, timestampsKeepNanosecondsAndNeverOverflow) {
    constexpr int64_t kBoot = 1'700'000'000'000'000'000;  // as seconds in a double, steps of 2e-7 s
    EXPECT_EQ(dplSecondsBetween(kBoot, kBoot + 1), 1e-9);
    EXPECT_NEAR(dplSecondsBetween(kBoot, kBoot + 86'400'000'000'011), 86400.000000011, 1e-9 / 8);
    EXPECT_EQ(dplSecondsBetween(kBoot + 500'000'000, kBoot), -0.5);
    const double longest = dplSecondsBetween(std::numeric_limits<int64_t>::min(), std::numeric_limits<int64_t>::max());
    EXPECT_NEAR(longest, 18446744073.709551615, 1e-5);
    double last = -1;
    for (int64_t ns = 0; ns < 3'000'000'000; ns += 13'888'889) {
        EXPECT_GT(dplSecondsBetween(kBoot, kBoot + ns), last) << "time stood still";
        last = dplSecondsBetween(kBoot, kBoot + ns);
    }
}

TEST(Convert, wrongInputsAreRefusedWithASentence) {
    const float good[4] = {0, 0, 0, 1}, zero[4] = {}, notFinite[4] = {0, kNan, 0, 1}, position[3] = {}, angles[4] = {-1, 1, 1, -1};
    DplCamera camera = emptyCamera();
    camera.fx = 7;
    const auto fails = [&](DplResult result, const char* word) {
        EXPECT_EQ(result, DPL_ERROR_INVALID_ARGUMENT) << word;
        EXPECT_NE(std::strstr(dplGetLastError(), word), nullptr) << dplGetLastError();
        EXPECT_EQ(camera.fx, 7) << "outputs are written only on DPL_OK";
    };
    fails(dplCameraFromAngles(nullptr, position, angles, 8, 8, &camera), "orientation is NULL");
    fails(dplCameraFromAngles(good, nullptr, angles, 8, 8, &camera), "position is NULL");
    fails(dplCameraFromAngles(good, position, nullptr, 8, 8, &camera), "anglesRad is NULL");
    fails(dplCameraFromAngles(good, position, angles, 8, 8, nullptr), "camera is NULL");
    fails(dplCameraFromAngles(zero, position, angles, 8, 8, &camera), "no rotation");
    fails(dplCameraFromAngles(notFinite, position, angles, 8, 8, &camera), "no rotation");
    fails(dplCameraFromAngles(good, notFinite, angles, 8, 8, &camera), "not finite");
    fails(dplCameraFromAngles(good, position, angles, 0, 8, &camera), "pixels");
    fails(dplCameraFromAngles(good, position, angles, 8, 8193, &camera), "8192");
    for (const auto& edges : {std::array<float, 4>{1, -1, 1, -1}, {-1, 1, -1, 1}, {0, 0, 0, 0}})
        fails(dplCameraFromAngles(good, position, edges.data(), 8, 8, &camera), "empty or mirrored");
    for (const auto& edges : {std::array<float, 4>{-1.6f, 1, 1, -1}, {-1, kNan, 1, -1}, {-1, 1, kInfinity, -1}})
        fails(dplCameraFromAngles(good, position, edges.data(), 8, 8, &camera), "89.9");

    std::array<float, 16> p{};
    const auto project = [&] {
        return dplCameraFromProjection(good, position, p.data(), DPL_CLIP_DEPTH_ZERO_TO_ONE, 8, 8, &camera, nullptr);
    };
    fails(project(), "perspective");
    p = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, -1, 1};
    fails(project(), "perspective");  // orthographic
    const std::array<float, 16> usual = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -1, 0, 0, -0.1f, 0};
    p = usual, p[0] = -1;
    fails(project(), "mirrors");
    p = usual, p[14] = 0;
    fails(project(), "depth");
    p = usual, p[4] = 0.1f;
    fails(project(), "skewed");
    p = usual, p[5] = kNan;
    fails(project(), "not finite");
    fails(dplCameraFromProjection(good, position, usual.data(), DplClipDepth(2), 8, 8, &camera, nullptr), "clip depth 2");
    float depth[2] = {};
    for (const auto& [a, b] : {std::array<float, 2>{1, 1}, {0, 1}, {-1, 1}, {kNan, 1}, {kInfinity, kInfinity}})
        fails(dplDepthFromPlanes(a, b, depth), "m is empty");
    float q[4], x[3];
    fails(dplPoseFromAxes(DplAxes(3), good, position, q, x), "axes 3");
    fails(dplPoseFromAxes(DPL_AXES_UNITY, good, position, nullptr, x), "output");
}

}  // namespace
