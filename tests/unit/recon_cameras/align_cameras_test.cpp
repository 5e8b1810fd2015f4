// SPDX-License-Identifier: Apache-2.0
// Cameras of two worlds are brought together, whatever the worlds, and their errors are what was put in.
#include "reconstruction/input/cameras/align_cameras.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/recon_cameras/made_cameras.h"

namespace dpl {
namespace {

const Similarity kWorld{0.37, turnAbout({1, -2, 0.5}, 2.1), {3, -1, 12}};

std::vector<Camerad> movedAll(const std::vector<Camerad>& cameras, const Similarity& world) {
    std::vector<Camerad> out;
    for (const Camerad& camera : cameras) out.push_back(moved(camera, world));
    return out;
}

TEST(AlignCameras, movedCameraSeesTheMovedPointAtTheSamePixel) {
    const Camerad camera = orbit(1)[0];
    const Vec3d point(0.2, 1.1, -0.3);
    const Vec2d before = camera.pixelOf(camera.toView(point));
    const Camerad after = moved(camera, kWorld);
    const Vec2d now = after.pixelOf(after.toView(kWorld(point)));
    EXPECT_NEAR(now.x, before.x, 1e-9);
    EXPECT_NEAR(now.y, before.y, 1e-9);
}

void expectWorldFound(const std::vector<Camerad>& cameras, const char* what) {
    const auto found = alignCameras(cameras, movedAll(cameras, kWorld));
    ASSERT_TRUE(found) << what;
    EXPECT_NEAR(found->scale, kWorld.scale, 1e-9) << what;
    for (const Vec3d& point : {Vec3d(0), Vec3d(1, 2, 3)}) EXPECT_LT(glm::length((*found)(point)-kWorld(point)), 1e-8) << what;
}

TEST(AlignCameras, similarityIsFoundForOrbitsLinesAndTwoCameras) {
    expectWorldFound(orbit(12), "orbit");
    expectWorldFound(orbit(2), "two cameras");
    auto line = orbit(5);
    for (size_t i = 0; i < line.size(); ++i) lookFrom(line[i], {0.1 * double(i), 1, 2}, {0, 1, 0});
    expectWorldFound(line, "eyes on a line");
}

TEST(AlignCameras, openScaleIsNoAnswer) {
    auto turning = orbit(6);
    for (size_t i = 0; i < turning.size(); ++i) lookFrom(turning[i], {0, 1, 2}, {0.2 * double(i), 1, 0});
    EXPECT_FALSE(alignCameras(turning, movedAll(turning, kWorld))) << "pure rotation";
    EXPECT_FALSE(alignCameras(orbit(1), orbit(1))) << "one camera";
    EXPECT_FALSE(alignCameras(orbit(3), orbit(4))) << "different counts";
    EXPECT_FALSE(alignCameras({}, {}));
}

TEST(AlignCameras, badCamerasDoNotMoveTheOthers) {
    const auto truth = orbit(20);
    auto cameras = truth;
    lookFrom(cameras[3], {9, 9, 9}, {0, 0, 0});
    lookFrom(cameras[11], {-9, 2, 4}, {5, 0, 0});
    const auto found = alignCameras(cameras, movedAll(truth, kWorld));
    ASSERT_TRUE(found);
    EXPECT_LT(glm::length((*found)(Vec3d(0, 1, 0)) - kWorld(Vec3d(0, 1, 0))), 1e-6);
    EXPECT_GT(cameraError(moved(cameras[3], *found), moved(truth[3], kWorld), {}).eye, 1);
}

TEST(AlignCameras, errorsAreThoseThatWerePutIn) {
    const Camerad truth = orbit(1)[0];
    Camerad off = truth;
    off.viewFromWorldRotation = turnAbout({0, 1, 0}, 0.002) * off.viewFromWorldRotation;
    off.viewFromWorldTranslation = turnAbout({0, 1, 0}, 0.002) * off.viewFromWorldTranslation;  // the eye stays
    const Vec3d ahead = truth.eye() + 2.0 * (glm::transpose(truth.viewFromWorldRotation) * Vec3d(0, 0, 1));
    const CameraError error = cameraError(off, truth, std::vector{ahead});
    EXPECT_NEAR(error.eye, 0, 1e-12);
    EXPECT_NEAR(error.rotationRad, 0.002, 1e-9);
    EXPECT_NEAR(error.px, truth.fx * std::tan(0.002), 1e-6);
    EXPECT_EQ(cameraError(off, truth, {}).px, -1);
}

}  // namespace
}  // namespace dpl
