// SPDX-License-Identifier: Apache-2.0
// Pictures and cameras turn together.
#include "reconstruction/input/import/turn.h"

#include "tests/unit/recon_import/made_captures.h"

namespace dpl {
namespace {

/** Two rows of three: 1 2 3 / 4 5 6. */
Picture numbered() {
    return {3, 2, 1, {1, 2, 3, 4, 5, 6}};
}

TEST(Turn, exifOrientationsMakePicturesUpright) {
    // What each orientation looks like once it is upright. From the table of tag 274 in TIFF 6.0: which sides row 0 and column 0 are.
    const std::vector<uint8_t> upright[8] = {{1, 2, 3, 4, 5, 6}, {3, 2, 1, 6, 5, 4}, {6, 5, 4, 3, 2, 1}, {4, 5, 6, 1, 2, 3},
                                             {1, 4, 2, 5, 3, 6}, {4, 1, 5, 2, 6, 3}, {6, 3, 5, 2, 4, 1}, {3, 6, 2, 5, 1, 4}};
    for (int orientation = 1; orientation <= 8; ++orientation) {
        const Picture picture = turned(numbered(), turnOfExif(orientation));
        EXPECT_EQ(picture.pixels, upright[orientation - 1]) << orientation;
        EXPECT_EQ(picture.widthPx, orientation < 5 ? 3u : 2u) << orientation;
    }
}

/** Pixel of a point seen through a lens (camera_check.h). */
Vec2d project(const Camerad& camera, const LensDistortion& lens, const Vec3d& world) {
    const Vec3d view = camera.toView(world);
    const double x = view.x / view.z, y = view.y / view.z, r2 = x * x + y * y, radial = 1 + lens.k1 * r2 + lens.k2 * r2 * r2;
    return camera.pixelOf(
        {x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x), y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y, 1});
}

TEST(Turn, camerasSeeTheSamePointInTheTurnedPicture) {
    Camerad camera;
    camera.widthPx = 120, camera.heightPx = 80, camera.fx = 90, camera.fy = 95, camera.cx = 57, camera.cy = 43;
    camera.viewFromWorldTranslation = {0.1, -0.2, 2};
    const LensDistortion lens{-0.1, 0.05, 0.01, -0.02};
    const Vec3d point(0.3, 0.2, 0.4);
    const Vec2d before = project(camera, lens, point);
    const Vec2d expected[4] = {before, {80 - before.y, before.x}, {120 - before.x, 80 - before.y}, {before.y, 120 - before.x}};
    for (int quarters = 0; quarters < 4; ++quarters) {
        Camerad turnedCamera = camera;
        LensDistortion turnedLens = lens;
        turnCamera(turnedCamera, turnedLens, {false, quarters});
        EXPECT_LT(glm::length(project(turnedCamera, turnedLens, point) - expected[quarters]), 1e-9) << quarters;
        EXPECT_EQ(turnedCamera.widthPx, quarters % 2 ? 80u : 120u);
    }
}

TEST(Turn, uprightTurnBringsTheWorldsUpToTheTop) {
    Camerad camera;
    camera.widthPx = 120, camera.heightPx = 80, camera.fx = camera.fy = 90;
    camera.viewFromWorldRotation = Mat3d(Vec3d(1, 0, 0), Vec3d(0, -1, 0), Vec3d(0, 0, -1));  // upright: +Y is up
    EXPECT_TRUE(uprightTurn(camera).none());
    for (int quarters = 1; quarters < 4; ++quarters) {
        Camerad tilted = camera;
        LensDistortion lens;
        turnCamera(tilted, lens, {false, quarters});
        EXPECT_EQ(uprightTurn(tilted).quarters, 4 - quarters);
    }
    camera.viewFromWorldRotation = Mat3d(Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(1, 0, 0));  // looks straight up
    EXPECT_TRUE(uprightTurn(camera).none());
}

}  // namespace
}  // namespace dpl
