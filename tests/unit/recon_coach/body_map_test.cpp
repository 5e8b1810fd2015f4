// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/body_map.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/coach/map_pictures.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "tests/unit/must.h"

namespace dpl {
namespace {

/** A plane z = 0 that faces +Z, `cells` by `cells` squares of two triangles. */
MeshData plane(double sideM, int cells, const Vec3d& centre = Vec3d(0)) {
    MeshData mesh;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x)
            mesh.restPositions.emplace_back(centre + sideM * Vec3d(double(x) / cells - 0.5, double(y) / cells - 0.5, 0));
    const auto at = [&](int x, int y) { return uint32_t(y * (cells + 1) + x); };
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) {
            mesh.triangles.emplace_back(at(x, y), at(x + 1, y), at(x + 1, y + 1));
            mesh.triangles.emplace_back(at(x, y), at(x + 1, y + 1), at(x, y + 1));
        }
    return mesh;
}

/** A sphere whose triangles face outwards. */
void addSphere(MeshData& mesh, const Vec3d& centre, double radiusM, int rings = 24) {
    const uint32_t first = uint32_t(mesh.restPositions.size());
    const int columns = 2 * rings;
    for (int r = 0; r <= rings; ++r)
        for (int c = 0; c <= columns; ++c) {
            const double polar = std::numbers::pi * r / rings, turn = 2 * std::numbers::pi * c / columns;
            mesh.restPositions.emplace_back(
                centre + radiusM * Vec3d(std::sin(polar) * std::sin(turn), std::cos(polar), std::sin(polar) * std::cos(turn)));
        }
    for (int r = 0; r < rings; ++r)
        for (int c = 0; c < columns; ++c) {
            const uint32_t a = first + uint32_t(r * (columns + 1) + c), b = a + uint32_t(columns) + 1;
            mesh.triangles.emplace_back(a, b, b + 1);
            mesh.triangles.emplace_back(a, b + 1, a + 1);
        }
}

Vec3d middleOf(const MeshData& mesh, size_t t) {
    const Triangle& c = mesh.triangles[t];
    return (Vec3d(mesh.restPositions[c.x]) + Vec3d(mesh.restPositions[c.y]) + Vec3d(mesh.restPositions[c.z])) / 3.0;
}
Vec3d normalOf(const MeshData& mesh, size_t t) {
    const Triangle& c = mesh.triangles[t];
    const Vec3d a(mesh.restPositions[c.x]);
    return glm::normalize(glm::cross(Vec3d(mesh.restPositions[c.y]) - a, Vec3d(mesh.restPositions[c.z]) - a));
}

/** Whether the segment from `from` to `to` meets a triangle before 99.9 % of its length. */
bool isHidden(const MeshData& mesh, const Vec3d& from, const Vec3d& to) {
    const Vec3d d = to - from;
    for (const Triangle& c : mesh.triangles) {
        const Vec3d a(mesh.restPositions[c.x]), e1 = Vec3d(mesh.restPositions[c.y]) - a, e2 = Vec3d(mesh.restPositions[c.z]) - a;
        const Vec3d p = glm::cross(d, e2);
        const double det = glm::dot(e1, p);
        if (std::abs(det) < 1e-14) continue;
        const Vec3d s = from - a, q = glm::cross(s, e1);
        const double u = glm::dot(s, p) / det, v = glm::dot(d, q) / det, t = glm::dot(e2, q) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && t > 1e-9 && t < 0.999) return true;
    }
    return false;
}

TEST(BodyMap, aPlaneAtThreeMetresHasPixelsOfDepthOverFocalLength) {
    const MeshData mesh = plane(1.0, 20);
    const Camerad camera = orbitCamera(Vec3d(0), 3, 0, 0, 600, 400, 300);
    const auto sights = lookAt(mesh.restPositions, mesh.triangles, camera);
    size_t seen = 0;
    for (const Sight& sight : sights) {
        if (!(sight.pixelM > 0)) continue;
        ++seen;
        EXPECT_NEAR(sight.pixelM, 3.0 / 600, 1e-7);  // everywhere on a plane parallel to the picture
        EXPECT_TRUE(sight.straight);
    }
    EXPECT_EQ(seen, mesh.triangles.size());
}

TEST(BodyMap, aTurnedPlaneHasPixelsLongerByTheCosine) {
    const MeshData mesh = plane(0.02, 2);  // small: depth hardly varies over it
    for (const double degrees : {30.0, 55.0, 65.0, 75.0}) {
        const double turn = degrees * std::numbers::pi / 180;
        const auto sights = lookAt(mesh.restPositions, mesh.triangles, orbitCamera(Vec3d(0), 3, turn, 0, 600, 400, 300));
        for (const Sight& sight : sights) {
            EXPECT_NEAR(sight.pixelM * std::cos(turn), 3.0 / 600, 0.02 * 3.0 / 600) << degrees;
            EXPECT_EQ(sight.straight, degrees < 60) << degrees;
        }
    }
    for (const double degrees : {78.0, 95.0, 180.0})
        for (const Sight& sight :
             lookAt(mesh.restPositions, mesh.triangles, orbitCamera(Vec3d(0), 3, degrees * std::numbers::pi / 180, 0, 600, 400, 300)))
            EXPECT_EQ(sight.pixelM, 0) << degrees << ": too steep, or from behind";
}

TEST(BodyMap, aSphereHasTheAnalyticPixelAtEveryAngle) {
    MeshData mesh;
    const double radius = 0.3, distance = 2.5, focal = 500;
    addSphere(mesh, Vec3d(0), radius, 60);
    const Camerad camera = orbitCamera(Vec3d(0), distance, 0, 0, focal, 300, 300);
    const auto sights = lookAt(mesh.restPositions, mesh.triangles, camera);
    size_t compared = 0;
    for (size_t t = 0; t < sights.size(); ++t) {
        if (!(sights[t].pixelM > 0)) continue;
        // With φ the polar angle from the axis, the surface point (R sin φ, D − R cos φ) projects to f R sin φ / (D − R cos φ). The pixel
        // is the inverse of that curve's derivative by arc length.
        const double cosine = middleOf(mesh, t).z / glm::length(middleOf(mesh, t)), depth = distance - radius * cosine;
        const double slope = focal * (distance * cosine - radius) / (depth * depth);
        EXPECT_NEAR(sights[t].pixelM, 1 / slope, 0.06 / slope) << t;  // a triangle is 3° wide: its normal is off by up to 1°
        ++compared;
    }
    EXPECT_GT(compared, sights.size() / 4);
}

TEST(BodyMap, viewsAgreeWithRaysThroughEveryTriangle) {
    MeshData mesh = plane(1.2, 12, {0, 0, -0.6});  // a wall behind two balls, one before the other
    addSphere(mesh, {0, 0, 0}, 0.3);
    addSphere(mesh, {0.25, 0.1, 0.7}, 0.15);
    std::vector<uint32_t> wanted(mesh.triangles.size(), 0), found(mesh.triangles.size(), 0);
    size_t decisions = 0, differ = 0;
    for (int i = 0; i < 8; ++i) {
        const Camerad camera = orbitCamera(Vec3d(0), 2.5, -1.2 + 0.35 * i, 0.15, 420, 320, 320);
        const auto sights = lookAt(mesh.restPositions, mesh.triangles, camera);
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            const Vec3d middle = middleOf(mesh, t), toEye = camera.eye() - middle;
            if (!(glm::length(glm::cross(Vec3d(mesh.restPositions[mesh.triangles[t].y]) - Vec3d(mesh.restPositions[mesh.triangles[t].x]),
                                         Vec3d(mesh.restPositions[mesh.triangles[t].z]) - Vec3d(mesh.restPositions[mesh.triangles[t].x]))) >
                  1e-12))
                continue;  // at the poles
            const double cosine = glm::dot(normalOf(mesh, t), glm::normalize(toEye));
            const Vec2d px = camera.pixelOf(camera.toView(middle));
            const bool inside = px.x >= 0 && px.y >= 0 && px.x < camera.widthPx && px.y < camera.heightPx;
            const bool truth = inside && cosine > std::cos(76 * std::numbers::pi / 180) && !isHidden(mesh, camera.eye(), middle);
            ++decisions, differ += truth != (sights[t].pixelM > 0);
            wanted[t] += truth, found[t] += sights[t].pixelM > 0;
        }
    }
    // They differ where a ball's shadow ends within a triangle, and at its own rim: 1.4 % measured.
    EXPECT_LT(double(differ), 0.025 * double(decisions));
    EXPECT_GT(decisions, 20000u);
    size_t hidden = 0;
    for (size_t t = 0; t < wanted.size(); ++t) {
        EXPECT_NEAR(found[t], wanted[t], 2.0) << t;
        hidden += wanted[t] == 0;
    }
    EXPECT_GT(hidden, mesh.triangles.size() / 10) << "the case must have hidden triangles";
}

TEST(BodyMap, theMaskTellsWhoIsSeen) {
    const MeshData mesh = plane(1.0, 10);
    const Camerad camera = orbitCamera(Vec3d(0), 3, 0, 0, 600, 400, 300);
    ImageGrey8 mask{400, 300, std::vector<uint8_t>(400 * 300, 0)};
    for (uint32_t y = 0; y < 300; ++y)
        for (uint32_t x = 0; x < 200; ++x) mask.pixels[y * 400 + x] = 255;
    const auto sights = lookAt(mesh.restPositions, mesh.triangles, camera, &mask);
    for (size_t t = 0; t < sights.size(); ++t)
        EXPECT_EQ(sights[t].pixelM > 0, camera.pixelOf(camera.toView(middleOf(mesh, t))).x < 200) << t;
}

TEST(BodyMap, theBestPictureOfATriangleCountsAndBlurMakesAPictureWorse) {
    std::vector<SeenTriangle> map(1);
    addPicture(map, std::vector<Sight>{{0.004f, true}}, 0);
    EXPECT_FLOAT_EQ(map[0].detailM, 0.004f);
    addPicture(map, std::vector<Sight>{{0.001f, false}}, 6);  // nearer, but blurred: no better
    EXPECT_FLOAT_EQ(map[0].detailM, 0.004f);
    EXPECT_EQ(map[0].views, 1u) << "seen at a steep angle";
    addPicture(map, std::vector<Sight>{{0.001f, true}}, 2);
    EXPECT_FLOAT_EQ(map[0].detailM, 0.002f);
    EXPECT_FLOAT_EQ(map[0].pixelM, 0.001f);
    EXPECT_EQ(map[0].views, 2u);
    addPicture(map, std::vector<Sight>{{0, false}}, 0);  // does not see it
    EXPECT_EQ(map[0].views, 2u);
}

TEST(BodyMap, itsPicturesShowTheSurfaceInTheColoursOfTheScale) {
    MeshData mesh;
    addSphere(mesh, Vec3d(0), 0.5);
    std::vector<SeenTriangle> map(mesh.triangles.size());
    for (size_t t = 0; t < map.size(); ++t)
        if (middleOf(mesh, t).x > 0) map[t] = {8, 0.0005f, 0.0f, 0.0005f};  // the right half of the front picture; the rest is not seen
    const auto pictures = must(drawMap(mesh, map));
    ASSERT_EQ(pictures.size(), 3u);
    const Picture drawn = must(decodePicture(pictures[0].png, PictureChannels::Rgb));
    const auto at = [&](uint32_t x, uint32_t y) { return &drawn.pixels[(y * drawn.widthPx + x) * 3]; };
    const uint32_t quarter = drawn.widthPx / 4, row = 26 + (drawn.heightPx - 26 - 56) / 2;
    const uint8_t *seen = at(quarter + 30, row), *unseen = at(quarter - 30, row);
    EXPECT_GT(int(seen[0]), 180);
    EXPECT_LT(int(seen[2]), 80);  // the best value is yellow
    EXPECT_EQ(unseen[0], unseen[1]);
    EXPECT_EQ(unseen[1], unseen[2]);
    EXPECT_FALSE(bool(drawMap(mesh, {})));
}

}  // namespace
}  // namespace dpl
