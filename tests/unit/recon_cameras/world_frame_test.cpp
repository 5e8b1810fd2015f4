// SPDX-License-Identifier: Apache-2.0
// A world of any scale and axes is turned into metres, +Y up, with the subject at the origin facing +Z.
#include "reconstruction/input/cameras/world_frame.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_cameras/made_cameras.h"

namespace dpl {
namespace {

const Similarity kAnyWorld{0.31, turnAbout({0.3, -1, 0.8}, 1.9), {4, 2, -7}};

struct Scene {
    std::vector<Camerad> cameras;
    std::vector<Vec3d> points;
    StandingPoints subject;
};

/** A subject of 1.8 m at the origin, seen in another world. All cameras are rolled by `rollRad`, as a phone held aslant. */
Scene sceneIn(const Similarity& world, double rollRad) {
    Scene scene;
    for (Camerad camera : orbit(20)) {
        const Mat3d roll = turnAbout({0, 0, 1}, rollRad);
        camera.viewFromWorldRotation = roll * camera.viewFromWorldRotation;
        camera.viewFromWorldTranslation = roll * camera.viewFromWorldTranslation;
        scene.cameras.push_back(moved(camera, world));
    }
    std::mt19937 random(3);
    std::normal_distribution<double> rough(0, 0.003);
    for (Vec3d p : roomPoints(900, 8)) {
        p.y += rough(random);
        scene.points.push_back(world(p));
    }
    scene.subject = {world({0, 1.8, 0.02}),  world({0.2, 1.45, 0}),  world({-0.2, 1.45, 0}), world({0.1, 0.95, 0}),
                     world({-0.1, 0.95, 0}), world({0.12, 0.08, 0}), world({-0.12, 0.08, 0})};
    return scene;
}

/** Distance by which the found frame misplaces a point of the true world. */
double misplaced(const WorldFrame& frame, const Similarity& world, const Vec3d& p) {
    return glm::length(frame.worldFromCameras(world(p)) - p);
}

TEST(WorldFrame, floorHeightAndKeypointsGiveTheTrueWorld) {
    const Scene scene = sceneIn(kAnyWorld, 0.05);
    const auto frame = findWorldFrame({scene.cameras, scene.points, scene.subject, 1.8});
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->floorFound);
    EXPECT_TRUE(frame->metric);
    EXPECT_TRUE(frame->facingFound);
    EXPECT_LT(misplaced(*frame, kAnyWorld, {0, 0, 0}), 0.01);
    EXPECT_LT(misplaced(*frame, kAnyWorld, {0, 1.8, 0}), 0.01);
    EXPECT_LT(misplaced(*frame, kAnyWorld, {1, 1, 1}), 0.02);
}

TEST(WorldFrame, withoutAFloorUpIsThatOfTheCameras) {
    const Scene scene = sceneIn(kAnyWorld, 0);
    const auto frame = findWorldFrame({scene.cameras, {}, scene.subject, 1.8});
    ASSERT_TRUE(frame);
    EXPECT_FALSE(frame->floorFound);
    // The ankles stand for the floor: 8 cm of 1.8 m is close to the share that is assumed.
    EXPECT_LT(misplaced(*frame, kAnyWorld, {0, 1.8, 0}), 0.03);
}

TEST(WorldFrame, withoutAHeightTheScaleIsAGuess) {
    const Scene scene = sceneIn(kAnyWorld, 0);
    const auto frame = findWorldFrame({scene.cameras, scene.points, scene.subject, 0});
    ASSERT_TRUE(frame);
    EXPECT_FALSE(frame->metric);
    const Vec3d head = frame->worldFromCameras(*scene.subject.headTop);
    EXPECT_NEAR(head.y, kAssumedHeightM, 0.01);
}

TEST(WorldFrame, withoutKeypointsTheFirstPictureIsTheFront) {
    const Scene scene = sceneIn(kAnyWorld, 0);
    const auto frame = findWorldFrame({scene.cameras, scene.points, {}, 1.8});
    ASSERT_TRUE(frame);
    EXPECT_FALSE(frame->facingFound);
    EXPECT_FALSE(frame->metric);
    const Vec3d eye = moved(scene.cameras[0], frame->worldFromCameras).eye();
    EXPECT_NEAR(eye.x, 0, 0.05 * glm::length(eye));
    EXPECT_GT(eye.z, 0);
    EXPECT_NEAR(frame->worldFromCameras(kAnyWorld(Vec3d(0))).y, 0, 0.02);
}

TEST(WorldFrame, nothingToGoByIsNoAnswer) {
    EXPECT_FALSE(findWorldFrame({}));
    const auto one = orbit(1);
    EXPECT_FALSE(findWorldFrame({one, {}, {}, 1.8}));
    auto down = orbit(4);
    for (size_t i = 0; i < 4; ++i) {  // all look straight down, each turned by a quarter
        down[i].viewFromWorldRotation = turnAbout({0, 0, 1}, std::numbers::pi / 2 * double(i)) * Mat3d(1, 0, 0, 0, 0, -1, 0, 1, 0);
        down[i].viewFromWorldTranslation = {0, 0, 3};
    }
    EXPECT_FALSE(findWorldFrame({down, {}, {}, 1.8}));
}

TEST(WorldFrame, fewOrSteepPointsAreNoFloor) {
    const auto cameras = orbit(12);
    std::vector<Vec3d> points = roomPoints(900, 8);
    EXPECT_TRUE(findFloor(points, cameras, {0, 1, 0}));
    EXPECT_FALSE(findFloor(std::span(points).first(30), cameras, {0, 1, 0}));
    const Vec3d tilted = turnAbout({1, 0, 0}, 0.5) * Vec3d(0, 1, 0);
    const auto floor = findFloor(points, cameras, tilted);
    EXPECT_TRUE(!floor || std::acos(glm::dot(floor->normal, tilted)) < 0.27) << "a plane that is not level was taken for the floor";
}

}  // namespace
}  // namespace dpl
