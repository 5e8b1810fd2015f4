// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/camera_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "reconstruction/input/cameras/camera_convention.h"

namespace dpl {
namespace {

Camerad good() {
    Camerad c{640, 480, 500, 500, 320, 240};
    const double a = 0.7;
    c.viewFromWorldRotation = Mat3d(std::cos(a), 0, -std::sin(a), 0, 1, 0, std::sin(a), 0, std::cos(a));
    c.viewFromWorldTranslation = {0.1, -0.2, 3};
    return c;
}

void expectRefused(const std::function<void(Camerad&)>& breakIt, const char* word) {
    Camerad c = good();
    breakIt(c);
    const Status status = checkCamera(c, "file frame 7");
    ASSERT_FALSE(status) << word;
    EXPECT_NE(status.error().message.find("file frame 7"), std::string::npos);
    EXPECT_NE(status.error().message.find(word), std::string::npos) << status.error().message;
}

TEST(CameraCheck, acceptsAGoodCameraAndPolishesARoundedRotation) {
    Camerad c = good();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) c.viewFromWorldRotation[i][j] = std::round(c.viewFromWorldRotation[i][j] * 1e4) / 1e4;
    ASSERT_TRUE(checkCamera(c, "x"));
    const Mat3d rtr = glm::transpose(c.viewFromWorldRotation) * c.viewFromWorldRotation;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(rtr[i][j], i == j, 1e-14);
}

TEST(CameraCheck, refusesEachWrongNumber) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const double bad : {0.0, -500.0, nan, inf}) {
        expectRefused([&](Camerad& c) { c.fx = bad; }, "fx");
        expectRefused([&](Camerad& c) { c.fy = bad; }, "fy");
    }
    expectRefused([](Camerad& c) { c.fx = 26; }, "field of view");
    expectRefused([&](Camerad& c) { c.cx = nan; }, "principal point");
    expectRefused([](Camerad& c) { c.cy = -1000; }, "principal point");
    expectRefused([](Camerad& c) { c.widthPx = 0; }, "image size");
    expectRefused([](Camerad& c) { c.widthPx = c.heightPx = 1u << 20; }, "64 million");
    expectRefused([](Camerad& c) { c.viewFromWorldRotation[0] = -c.viewFromWorldRotation[0]; }, "mirrors");
    expectRefused([](Camerad& c) { c.viewFromWorldRotation *= 1.01; }, "not a rotation");
    expectRefused([](Camerad& c) { c.viewFromWorldRotation[1][0] += 0.01; }, "not a rotation");
    expectRefused([&](Camerad& c) { c.viewFromWorldRotation[2][2] = nan; }, "not finite");
    expectRefused([](Camerad& c) { c.viewFromWorldRotation = Mat3d(0.0); }, "not a rotation");
    expectRefused([&](Camerad& c) { c.viewFromWorldTranslation.y = inf; }, "not finite");
    expectRefused([](Camerad& c) { c.viewFromWorldTranslation.y = 1e9; }, "units");
}

TEST(CameraCheck, refusesALensThatFoldsInsideThePicture) {
    const Camerad c = good();
    EXPECT_TRUE(checkDistortion({-0.2, 0.03, 1e-3, -1e-3}, c, "x"));
    EXPECT_FALSE(checkDistortion({-0.8, 0, 0, 0}, c, "x"));
    EXPECT_FALSE(checkDistortion({0, 0, 0.5, 0}, c, "x"));
    EXPECT_FALSE(checkDistortion({std::numeric_limits<double>::quiet_NaN(), 0, 0, 0}, c, "x"));
}

TEST(CameraConvention, turningTheWorldMovesPointsAndCamerasAlike) {
    Camerad c = good();
    const Vec3d p(0.3, -0.8, 1.4);
    const Vec3d before = c.toView(p);
    turnZUpWorld(c);
    const Vec3d after = c.toView(turnZUpPoint(p));
    EXPECT_NEAR(glm::length(after - before), 0, 1e-15);
    EXPECT_EQ(turnZUpPoint({0, 0, 1}), Vec3d(0, 1, 0));
    EXPECT_EQ(turnZUpPoint({0, -1, 0}), Vec3d(0, 0, 1));
}

}  // namespace
}  // namespace dpl
