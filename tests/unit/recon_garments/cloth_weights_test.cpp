// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/garments/cloth_weights.h"

#include <cmath>

#include <gtest/gtest.h>

namespace dpl {
namespace {

TEST(ClothWeights, aVertexWhoseJointsCancelMovesWithItsNeighbours) {
    // A strip on joint 0, whose middle vertex is half on joint 1, turned by 180° against joint 0: the blend has rank one.
    SurfaceMesh strip;
    for (int i = 0; i < 7; ++i) strip.positions.push_back({0.1f * float(i / 2), 0.1f * float(i % 2), 0});
    for (uint32_t i = 0; i + 2 < 7; ++i) strip.triangles.push_back(i % 2 ? Triangle(i + 1, i, i + 2) : Triangle(i, i + 1, i + 2));
    ClothWeights weights;
    weights.joints.assign(7, {0, 1, 0, 0});
    weights.weights.assign(7, {255, 0, 0, 0});
    weights.weights[3] = {128, 127, 0, 0};
    const Mat3x4f shifted(Vec3f(1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, 0, 1), Vec3f(0.5f, 0, 0));
    const Mat3x4f turned(Vec3f(-1, 0, 0), Vec3f(0, -1, 0), Vec3f(0, 0, 1), Vec3f(0));
    const std::vector<Mat3x4f> worldFromRest{shifted, turned};
    const std::vector<Vec3f> rest = unposed(strip, weights, worldFromRest);
    for (size_t v = 0; v < 7; ++v) {
        EXPECT_NEAR(rest[v].x, strip.positions[v].x - 0.5f, 1e-5);
        EXPECT_NEAR(rest[v].y, strip.positions[v].y, 1e-5);
    }
}

}  // namespace
}  // namespace dpl
