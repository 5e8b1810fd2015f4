// SPDX-License-Identifier: Apache-2.0
#include "platform/android/native/rotated_view.h"

#include <gtest/gtest.h>

#include <array>

namespace dpl::android {
namespace {

DplCamera someCamera() {
    // A view that is turned, moved and off its axis, so that a wrong sign shows.
    return {sizeof(DplCamera), 60, 100, 80, 90, 25, 55, {0.6f, 0, -0.8f, 0.1f, 0.48f, -0.8f, 0.36f, 0.9f, -0.64f, -0.6f, -0.48f, 3}};
}

/** Where a point of the world is seen, pixels. */
std::array<float, 2> pixelOf(const DplCamera& c, const std::array<float, 3>& p) {
    float view[3];
    for (int r = 0; r < 3; ++r) {
        const float* m = c.viewFromWorld + 4 * r;
        view[r] = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
    }
    return {c.fx * view[0] / view[2] + c.cx, c.fy * view[1] / view[2] + c.cy};
}

TEST(RotatedView, aQuarterTurnMovesPixelsClockwise) {
    const DplCamera camera = someCamera();
    const DplCamera turned = rotatedView(camera, VK_SURFACE_TRANSFORM_ROTATE_90_BIT_KHR);
    EXPECT_EQ(turned.widthPx, 100u);
    EXPECT_EQ(turned.heightPx, 60u);
    for (const std::array<float, 3> point : {std::array{0.1f, 0.7f, 0.2f}, std::array{-0.4f, 1.1f, -0.3f}}) {
        const auto before = pixelOf(camera, point), after = pixelOf(turned, point);
        EXPECT_NEAR(after[0], 100 - before[1], 1e-4f);
        EXPECT_NEAR(after[1], before[0], 1e-4f);
    }
}

TEST(RotatedView, halfATurnIsTwoQuartersAndThreeQuartersAndOneAreNone) {
    const DplCamera camera = someCamera();
    constexpr auto kQuarter = VK_SURFACE_TRANSFORM_ROTATE_90_BIT_KHR;
    const std::array point{0.1f, 0.7f, 0.2f};
    const auto half = pixelOf(rotatedView(camera, VK_SURFACE_TRANSFORM_ROTATE_180_BIT_KHR), point);
    const auto before = pixelOf(camera, point);
    EXPECT_NEAR(half[0], 60 - before[0], 1e-4f);
    EXPECT_NEAR(half[1], 100 - before[1], 1e-4f);
    const DplCamera whole = rotatedView(rotatedView(camera, VK_SURFACE_TRANSFORM_ROTATE_270_BIT_KHR), kQuarter);
    for (int i = 0; i < 12; ++i) EXPECT_EQ(whole.viewFromWorld[i], camera.viewFromWorld[i]) << i;
    EXPECT_EQ(whole.cx, camera.cx);
    EXPECT_EQ(whole.fy, camera.fy);
}

TEST(RotatedView, isTheSameWithoutATurn) {
    const DplCamera camera = someCamera();
    EXPECT_EQ(pixelOf(rotatedView(camera, VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR), {0, 1, 0}), pixelOf(camera, {0, 1, 0}));
}

TEST(FittedView, keepsWhatIsSeenAtTheEdges) {
    const DplCamera camera = someCamera(), wide = fittedView(camera, {120, 100});
    const auto before = pixelOf(camera, {0.1f, 0.7f, 0.2f}), after = pixelOf(wide, {0.1f, 0.7f, 0.2f});
    EXPECT_NEAR(after[0], 2 * before[0], 1e-4f);
    EXPECT_NEAR(after[1], before[1], 1e-4f);
    EXPECT_EQ(wide.widthPx, 120u);
}

TEST(RotatedDepth, movesAsThePictureDoes) {
    DplCamera camera = someCamera();
    camera.widthPx = 3, camera.heightPx = 2;
    const std::vector<float> scene = {1, 2, 3, 4, 5, 6};
    camera.sceneDepthM = scene.data(), camera.sceneDepthCount = scene.size();
    std::vector<float> turned;
    const auto expect = [&](VkSurfaceTransformFlagBitsKHR transform, const std::vector<float>& wanted) {
        rotatedDepth(camera, {3, 2}, transform, turned);
        EXPECT_EQ(turned, wanted) << transform;
    };
    expect(VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR, scene);
    expect(VK_SURFACE_TRANSFORM_ROTATE_90_BIT_KHR, {4, 1, 5, 2, 6, 3});  // as pixel (u, v) moves to (h - v, u)
    expect(VK_SURFACE_TRANSFORM_ROTATE_180_BIT_KHR, {6, 5, 4, 3, 2, 1});
    expect(VK_SURFACE_TRANSFORM_ROTATE_270_BIT_KHR, {3, 6, 2, 5, 1, 4});
    rotatedDepth(camera, {6, 1}, VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR, turned);
    EXPECT_EQ(turned, (std::vector<float>{1, 1, 2, 2, 3, 3})) << "a picture of another size takes the depth of the same place";
}

}  // namespace
}  // namespace dpl::android
