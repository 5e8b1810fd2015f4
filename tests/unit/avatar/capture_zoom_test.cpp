// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/capture_zoom.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sdk/avatar/rig.h"

namespace dpl {
namespace {

/** Hips at 1 m and a head at 1.6 m; the spine between them moves no surface of its own. */
struct Person {
    std::vector<JointData> joints{{"hips", -1, {0, 1, 0}, "hips"}, {"spine", 0, {0, 1.3f, 0}, "spine"}, {"head", 1, {0, 1.6f, 0}, "head"}};
    CaptureMapData map;
    std::vector<Mat3x4f> transforms;

    Person() {
        map.sides.assign(3 * kCaptureSides, {});
        for (size_t s = 0; s < kCaptureSides; ++s) map.sides[s] = {0.004f, 0.004f, 9};
        map.sides[8] = {0.001f, 0.001f, 9}, map.sides[9] = {0.002f, 0.002f, 9}, map.sides[10] = {}, map.sides[11] = {0.002f, 0.002f, 9};
        pose(Pose::rest(3));
    }
    void pose(const Pose& pose) { jointTransforms(joints, pose, transforms); }
    float nearest(const Vec3f& point, const Vec3f& toEye, float focalPx = 1000, float magnification = 4) const {
        return nearestDistanceM(map, joints, transforms, point, toEye, focalPx, magnification);
    }
};

TEST(CaptureZoom, aDetailIsDrawnOverAsManyPixelsAsAsked) {
    const Person person;
    const float distance = person.nearest({0, 1.6f, 0}, {0, 0, 1});
    EXPECT_NEAR(0.001f * 1000 / distance, 4, 0.01);
    EXPECT_NEAR(person.nearest({0, 1.6f, 0}, {0, 0, 1}, 2000), 2 * distance, 1e-5) << "in a picture of twice the size";
    EXPECT_NEAR(person.nearest({0, 1.6f, 0}, {0, 0, 1}, 1000, 8), distance / 2, 1e-5);
}

TEST(CaptureZoom, theSideThatTheEyeIsOnDecidesAndAnUnseenOneIsTheCoarsest) {
    const Person person;
    const Vec3f head(0, 1.6f, 0);
    EXPECT_NEAR(person.nearest(head, {0, 0, 2}), 0.25, 1e-3);
    EXPECT_NEAR(person.nearest(head, {2, 0, 0}), 0.5, 1e-3);
    EXPECT_NEAR(person.nearest(head, {0, 0, -2}), 0.5, 1e-3) << "no picture shows the back of the head";
    const float between = person.nearest(head, {1, 0, 1});
    EXPECT_NEAR(between, std::sqrt(0.25 * 0.5), 1e-3);
    EXPECT_NEAR(person.nearest(head, {0, 3, 0}), std::sqrt(std::sqrt(0.25 * 0.5 * 0.5 * 0.5)), 1e-3) << "from above: all sides alike";
}

TEST(CaptureZoom, turnsWithThePoseAndSkipsJointsWithoutSurface) {
    Person person;
    EXPECT_NEAR(person.nearest({0, 1.28f, 0}, {0, 0, 1}), 1.0, 1e-3) << "the spine is nearest, but the hips know";
    Pose turned = Pose::rest(3);
    turned.localRotations[2] = glm::angleAxis(float(std::numbers::pi / 2), Vec3f(0, 1, 0));  // the head looks to its left, +X
    turned.rootTranslation = {5, 0, 0};
    person.pose(turned);
    EXPECT_NEAR(person.nearest({5, 1.6f, 0}, {1, 0, 0}), 0.25, 1e-3) << "the face is there now";
}

TEST(CaptureZoom, withoutAMapThereIsNoLimit) {
    Person person;
    person.map.sides.clear();
    EXPECT_EQ(person.nearest({0, 1.6f, 0}, {0, 0, 1}), 0);
    person.map.sides.assign(3 * kCaptureSides, {});
    EXPECT_EQ(person.nearest({0, 1.6f, 0}, {0, 0, 1}), 0);
}

}  // namespace
}  // namespace dpl
