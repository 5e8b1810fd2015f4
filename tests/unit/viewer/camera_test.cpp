// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "apps/viewer/orbit_camera.h"

namespace {

using namespace dpl;

constexpr uint32_t kWidth = 800, kHeight = 600;

Camerad cameraOf(const OrbitCamera& orbit) {
    return orbit.camera(kWidth, kHeight, 0.5 * kWidth);
}

Vec2d pixelOf(const OrbitCamera& orbit, const Vec3d& world) {
    const Camerad camera = cameraOf(orbit);
    return camera.pixelOf(camera.toView(world));
}

TEST(OrbitCamera, keepsAwayButDoesNotComeNearer) {
    OrbitCamera orbit;
    orbit.zoom(100);
    orbit.keepAway(1.5);
    EXPECT_DOUBLE_EQ(orbit.distanceM(), 1.5);
    orbit.keepAway(0.7);
    EXPECT_DOUBLE_EQ(orbit.distanceM(), 1.5);
    orbit.keepAway(0);  // no limit
    orbit.keepAway(1e9);
    EXPECT_LE(orbit.distanceM(), OrbitCamera::kMaxDistanceM);
}

TEST(OrbitCamera, showsItsMiddleWhereItIsTold) {
    OrbitCamera orbit;
    orbit.orbit(123, -45, kHeight);
    const Camerad camera = orbit.camera(kWidth, kHeight, 550);
    const Vec3d view = camera.toView(orbit.middle());
    EXPECT_NEAR(camera.pixelOf(view).x, 550, 1e-9);
    EXPECT_NEAR(camera.pixelOf(view).y, 300, 1e-9);
    EXPECT_NEAR(view.z, orbit.distanceM(), 1e-9);
}

TEST(OrbitCamera, viewIsARotationWithYDown) {
    OrbitCamera orbit;
    for (int i = 0; i < 20; ++i) {
        orbit.orbit(137, 61 * (i % 3 - 1), kHeight);
        const Mat3d r = cameraOf(orbit).viewFromWorldRotation;
        EXPECT_NEAR(glm::determinant(r), 1, 1e-12);
        const Mat3d unit = r * glm::transpose(r);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(glm::length(unit[c] - Mat3d(1)[c]), 0, 1e-12);
        EXPECT_GT(pixelOf(orbit, orbit.middle() - Vec3d(0, 0.1, 0)).y, pixelOf(orbit, orbit.middle()).y) << "low is down";
    }
}

TEST(OrbitCamera, whatIsInFrontFollowsTheMouse) {
    OrbitCamera before;
    const Vec3d nose = before.middle() + Vec3d(0, 0, 0.3);
    OrbitCamera after = before;
    after.orbit(50, 0, kHeight);
    EXPECT_GT(pixelOf(after, nose).x, pixelOf(before, nose).x + 1);
    after = before;
    after.orbit(0, 50, kHeight);
    EXPECT_GT(pixelOf(after, nose).y, pixelOf(before, nose).y + 1);
}

TEST(OrbitCamera, aDragByTheHeightIsHalfACircle) {
    OrbitCamera orbit;
    const Vec3d before = cameraOf(orbit).eye() - orbit.middle();
    orbit.orbit(kHeight, 0, kHeight);
    const Vec3d after = cameraOf(orbit).eye() - orbit.middle();
    EXPECT_NEAR(glm::length(after - Vec3d(-before.x, before.y, -before.z)), 0, 1e-9);
}

TEST(OrbitCamera, neverTurnsOverTheTop) {
    OrbitCamera orbit;
    orbit.orbit(0, 1e6, kHeight);
    EXPECT_EQ(orbit.elevationRad(), OrbitCamera::kMaxElevationRad);
    orbit.orbit(0, -1e7, kHeight);
    EXPECT_EQ(orbit.elevationRad(), -OrbitCamera::kMaxElevationRad);
}

TEST(OrbitCamera, panKeepsTheMiddleUnderTheMouse) {
    OrbitCamera orbit;
    orbit.orbit(200, 77, kHeight);
    const Vec3d held = orbit.middle();
    orbit.pan(31, -17, kHeight);
    EXPECT_NEAR(pixelOf(orbit, held).x, 400 + 31, 1e-9);
    EXPECT_NEAR(pixelOf(orbit, held).y, 300 - 17, 1e-9);
}

TEST(OrbitCamera, zoomHasEndsAndCanBeTakenBack) {
    OrbitCamera orbit;
    const double before = orbit.distanceM();
    orbit.zoom(3);
    EXPECT_NEAR(orbit.distanceM(), before * 0.729, 1e-12);
    orbit.zoom(-3);
    EXPECT_NEAR(orbit.distanceM(), before, 1e-12);
    orbit.zoom(1000);
    EXPECT_EQ(orbit.distanceM(), OrbitCamera::kMinDistanceM);
    orbit.zoom(-1000);
    EXPECT_EQ(orbit.distanceM(), OrbitCamera::kMaxDistanceM);
}

TEST(OrbitCamera, zoomKeepsWhatIsUnderTheMouse) {
    OrbitCamera orbit;
    orbit.orbit(200, 77, kHeight);
    const Mat3d axes = glm::transpose(cameraOf(orbit).viewFromWorldRotation);
    const Vec3d held = orbit.middle() + 0.4 * axes[0] - 0.7 * axes[1];
    const Vec2d px = pixelOf(orbit, held);
    for (const double steps : {3.0, -1.5, 1000.0}) {  // to the nearest distance too
        const double before = orbit.distanceM();
        orbit.zoom(steps, px.x - 400, px.y - 300, kHeight);
        EXPECT_NE(orbit.distanceM(), before);
        EXPECT_NEAR(pixelOf(orbit, held).x, px.x, 1e-9);
        EXPECT_NEAR(pixelOf(orbit, held).y, px.y, 1e-9);
    }
}

TEST(OrbitCamera, anotherLensKeepsTheSizeInTheMiddle) {
    OrbitCamera orbit;
    const auto tall = [&] { return pixelOf(orbit, orbit.middle()).y - pixelOf(orbit, orbit.middle() + Vec3d(0, 0.01, 0)).y; };
    const double before = tall();
    orbit.setFovY(1.2);
    EXPECT_DOUBLE_EQ(orbit.fovYRad(), 1.2);
    EXPECT_NEAR(tall(), before, 0.01 * before);
    EXPECT_LT(orbit.distanceM(), 2.2);
    orbit.setFovY(9);
    EXPECT_EQ(orbit.fovYRad(), OrbitCamera::kMostFovYRad);
    orbit.setFovY(0);
    EXPECT_EQ(orbit.fovYRad(), OrbitCamera::kLeastFovYRad);
}

TEST(OrbitCamera, looksCloserAtAPoint) {
    OrbitCamera orbit;
    const double before = orbit.distanceM();
    orbit.lookCloserAt({1, 2, 3});
    EXPECT_EQ(orbit.middle(), Vec3d(1, 2, 3));
    EXPECT_DOUBLE_EQ(orbit.distanceM(), before / 2);
}

TEST(OrbitCamera, framesABoxFromEverySide) {
    const WorldBox boxes[] = {{{-0.8, 0, -0.2}, {0.8, 1.8, 0.2}}, {{5, -1, 2}, {15, 0, 9}}};
    for (const WorldBox& box : boxes) {
        OrbitCamera orbit;
        orbit.frame(box, double(kWidth) / kHeight);
        double most = 0;
        for (int step = 0; step < 12; ++step) {
            orbit.setAzimuth(step * std::numbers::pi / 6);
            for (int corner = 0; corner < 8; ++corner) {
                const Vec3d p(corner & 1 ? box.low.x : box.high.x, corner & 2 ? box.low.y : box.high.y,
                              corner & 4 ? box.low.z : box.high.z);
                const Vec2d px = pixelOf(orbit, p);
                const double across = std::abs(px.x - 400) / 400, down = std::abs(px.y - 300) / 300;
                EXPECT_LE(across, 1);
                EXPECT_LE(down, 1);
                most = std::max({most, across, down});
            }
        }
        EXPECT_GT(most, 0.6) << "the box is too small in the picture";
    }
}

}  // namespace
