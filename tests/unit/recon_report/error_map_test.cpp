// SPDX-License-Identifier: Apache-2.0
// Where an avatar differs from its pictures: what a triangle gets, what no picture shows, and how it is drawn.
#include "reconstruction/judging/report/error_map.h"

#include <gtest/gtest.h>

#include <array>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "tests/unit/must.h"

namespace dpl {
namespace {

constexpr uint32_t kSidePx = 120;

/** A plane of 1 m that faces +Z: squares of two triangles, of which the last is turned round. */
MeshData plane(int cells) {
    MeshData mesh;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x) mesh.restPositions.emplace_back(float(x) / float(cells) - 0.5f, float(y) / float(cells) - 0.5f, 0);
    const auto at = [&](int x, int y) { return uint32_t(y * (cells + 1) + x); };
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) {
            mesh.triangles.emplace_back(at(x, y), at(x + 1, y), at(x + 1, y + 1));
            mesh.triangles.emplace_back(at(x, y), at(x + 1, y + 1), at(x, y + 1));
        }
    std::swap(mesh.triangles.back().y, mesh.triangles.back().z);
    return mesh;
}

Vec3f middleOf(const MeshData& mesh, size_t t) {
    const Triangle& c = mesh.triangles[t];
    return (mesh.restPositions[c.x] + mesh.restPositions[c.y] + mesh.restPositions[c.z]) / 3.0f;
}

TEST(ErrorMap, aTriangleGetsTheDifferenceThatAPictureShowsThere) {
    const MeshData mesh = plane(8);
    const Camerad camera = orbitCamera(Vec3d(0), 2, 0, 0, 2 * kSidePx, kSidePx, kSidePx);  // the plane fills the picture
    std::vector<uint8_t> shown(3 * kSidePx * kSidePx, 100), truth = shown;
    ImageGrey8 mask{kSidePx, kSidePx, std::vector<uint8_t>(kSidePx * kSidePx, 255)};
    for (uint32_t y = 0; y < kSidePx; ++y)
        for (uint32_t x = 0; x < kSidePx; ++x) {
            if (x < kSidePx / 2) truth[3 * (y * kSidePx + x)] = 40;  // in red, which is a third of it
            if (y < kSidePx / 4) mask.pixels[y * kSidePx + x] = 0;
        }
    const std::vector<float> levels = differenceOnSurface(mesh.restPositions, mesh.triangles, camera, shown, truth, mask);
    ASSERT_EQ(levels.size(), mesh.triangles.size());
    for (size_t t = 0; t + 1 < levels.size(); ++t) {
        const Vec3f middle = middleOf(mesh, t);
        if (middle.y > 0.25f)
            EXPECT_LT(levels[t], 0) << "nobody is there";
        else
            EXPECT_FLOAT_EQ(levels[t], middle.x < 0 ? 20 : 0) << middle.x << " " << middle.y;
    }
    EXPECT_LT(levels.back(), 0) << "it turns its back";
}

TEST(ErrorMap, framesAreTakenTogetherAndWhatNoneShowsIsGrey) {
    const MeshData mesh = plane(8);
    HeldOutFrame near, far, without;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const bool right = middleOf(mesh, t).x > 0;
        near.onSurface.push_back(right ? 1.0f : -1.0f);
        far.onSurface.push_back(right ? 3.0f : -1.0f);
    }
    EXPECT_TRUE(must(drawErrorMap(mesh, {})).empty());
    EXPECT_TRUE(must(drawErrorMap(mesh, std::vector{without})).empty());
    const auto pixelOf = [&](const std::vector<HeldOutFrame>& frames, bool right) {
        const Picture drawn = must(decodePicture(must(drawErrorMap(mesh, frames)), PictureChannels::Rgb));
        const size_t x = drawn.widthPx / 4 + (right ? 40 : -40), y = 26 + (drawn.heightPx - 26 - 56) / 2;
        const uint8_t* px = &drawn.pixels[(y * drawn.widthPx + x) * 3];
        return std::array<int, 3>{px[0], px[1], px[2]};
    };
    const auto best = pixelOf({near, far, without}, true), worse = pixelOf({far}, true), unseen = pixelOf({near, far}, false);
    EXPECT_GT(best[0], 180) << "the mean of 1 and 3 is the best of the scale, which is yellow";
    EXPECT_LT(best[2], 80);
    EXPECT_LT(worse[0], best[0]) << "3 alone is not";
    EXPECT_EQ(unseen[0], unseen[1]);
    EXPECT_EQ(unseen[1], unseen[2]);
}

}  // namespace
}  // namespace dpl
