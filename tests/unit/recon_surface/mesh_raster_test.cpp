// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/body_places.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace dpl;

Camerad frontCamera() {
    Camerad camera;
    camera.widthPx = 64, camera.heightPx = 48;
    camera.fx = camera.fy = 50, camera.cx = 32, camera.cy = 24;
    return camera;
}

TEST(MeshRaster, seesTheNearerOfTwoTrianglesAndItsPoint) {
    const std::vector<Vec3f> positions = {{-2, -2, 4}, {2, -2, 4}, {0, 3, 4}, {-2, -2, 2}, {2, -2, 3}, {0, 3, 2}};
    const std::vector<Triangle> triangles = {{0, 1, 2}, {3, 4, 5}};
    const Camerad camera = frontCamera();
    const MeshRaster raster = rasteriseMesh(positions, triangles, camera);
    const size_t pixel = 24 * 64 + 32;
    ASSERT_EQ(raster.triangle[pixel], 1u);
    const Vec2f uv = raster.barycentric[pixel];
    const Vec3f point = (1 - uv.x - uv.y) * positions[3] + uv.x * positions[4] + uv.y * positions[5];
    const Vec2d seen = camera.pixelOf(camera.toView(Vec3d(point)));
    EXPECT_NEAR(seen.x, 32.5, 1e-4);
    EXPECT_NEAR(seen.y, 24.5, 1e-4);
    EXPECT_NEAR(raster.depthM[pixel], point.z, 1e-5);
    EXPECT_EQ(raster.triangle[47 * 64], kNoTriangle) << "the lower left corner is beside both";
}

TEST(MeshRaster, nearerTriangleWinsAndBehindTheCameraNothingIsDrawn) {
    const Camerad camera{32, 32, 32, 32, 16, 16};
    const std::vector<Vec3f> p{{-5, -5, 4},  {5, -5, 4},   {0, 9, 4},   {-0.5f, -0.5f, 2}, {0.5f, -0.5f, 2},
                               {0, 0.9f, 2}, {-1, -1, -1}, {1, -1, -1}, {0, 1, -1}};
    const std::vector<Triangle> t{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
    const auto image = rasteriseMesh(p, t, camera);
    EXPECT_EQ(image.triangle[16 * 32 + 16], 1u);
    EXPECT_NEAR(image.depthM[16 * 32 + 16], 2, 1e-6);
    EXPECT_EQ(image.triangle[4 * 32 + 16], 0u);
    const std::vector<Triangle> behind{{6, 7, 8}};
    const auto empty = rasteriseMesh(p, behind, camera);
    EXPECT_EQ(empty.triangle[16 * 32 + 16], kNoTriangle);
    EXPECT_EQ(silhouetteIou(empty, std::vector<uint8_t>(32 * 32, 0)), 1);
    EXPECT_EQ(silhouetteIou(empty, std::vector<uint8_t>(32 * 32, 255)), 0);
}

TEST(MeshRaster, theFrontOfATriangleHasACosineAboveZero) {
    const std::vector<Vec3f> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    EXPECT_NEAR(frontCosine(positions, {0, 1, 2}, {0, 0, 5}), 1, 1e-12);
    EXPECT_NEAR(frontCosine(positions, {0, 2, 1}, {0, 0, 5}), -1, 1e-12);
    EXPECT_NEAR(frontCosine(positions, {0, 1, 2}, {3, 0, 4}), 0.8, 1e-12);
    EXPECT_EQ(frontCosine(positions, {0, 1, 1}, {0, 0, 5}), 0) << "no normal";
}

TEST(MeshRaster, aPlaneRecedesByItsSlopeTimesTheSizeOfAPixel) {
    Camerad camera = frontCamera();
    camera.fx = 100;
    EXPECT_NEAR(recedingM(0.6, 2, camera), 0.8 / 0.6 * 0.02, 1e-12);
    EXPECT_EQ(recedingM(1 + 1e-9, 2, camera), 0) << "seen straight, with a cosine rounded up";
}

TEST(BodyPlaces, middlesAreTheMeansOfTheCorners) {
    MeshData mesh;
    mesh.restPositions = {{0, 0, 0}, {3, 0, 0}, {0, 6, 0}, {3, 0, 9}};
    mesh.triangles = {{0, 1, 2}, {1, 2, 3}};
    EXPECT_EQ(restMiddles(mesh), (std::vector<Vec3f>{{1, 2, 0}, {2, 2, 3}}));
}

TEST(VertexColours, takesThePictureAndFillsWhatNobodySaw) {
    // A quad that the camera sees, and a vertex behind it, joined by an edge.
    const std::vector<Vec3f> positions = {{-1, -1, 3}, {-1, 1, 3}, {1, 1, 3}, {1, -1, 3}, {0, 0, 9}};
    const std::vector<Triangle> triangles = {{0, 1, 2}, {0, 2, 3}, {0, 4, 1}};
    const Camerad camera = frontCamera();
    const MeshRaster raster = rasteriseMesh(positions, triangles, camera);
    std::vector<uint8_t> rgb(64 * 48 * 3), mask(64 * 48, 255);
    for (size_t i = 0; i < mask.size(); ++i) rgb[i * 3] = 200, rgb[i * 3 + 1] = 100, rgb[i * 3 + 2] = 50;
    VertexColours colours(positions.size());
    colours.add(raster, positions, triangles, camera, rgb, mask);
    const auto out = colours.finish(triangles);
    for (const auto& c : out) {
        EXPECT_EQ(int(c.x), 200);
        EXPECT_EQ(int(c.y), 100);
        EXPECT_EQ(int(c.z), 50);
    }
}

}  // namespace
