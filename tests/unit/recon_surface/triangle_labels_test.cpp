// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/triangle_labels.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;

/** Four triangles side by side, without common edges. Two are seen with the labels 200 and 9, the third by one pixel of each, the fourth
 *  by none. */
TEST(TriangleLabels, anyValueVotesAndTheSmallerOneWinsATie) {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
    for (uint32_t t = 0; t < 4; ++t) {
        const float x = float(t) - 2;
        for (const Vec3f& p : {Vec3f(x, -1, 4), Vec3f(x, 1, 4), Vec3f(x + 0.9f, 0, 4)}) positions.push_back(p);
        triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    const Camerad camera{4, 1, 1, 1, 2, 0.5};
    MeshRaster raster;
    raster.triangle = {0, 1, 2, 2};
    TriangleLabels votes(triangles.size());
    const std::vector<uint8_t> labels = {200, 9, 200, 9}, mask(4, 255);
    votes.add(raster, positions, triangles, camera, labels, mask);
    // Seen under equal angles, the last two pixels count alike.
    EXPECT_EQ(votes.finish(triangles, 77), (std::vector<uint8_t>{200, 9, 9, 77}));
}

}  // namespace
