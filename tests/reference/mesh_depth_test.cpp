// SPDX-License-Identifier: Apache-2.0
// The CPU's mesh depth against a ray caster in double precision.
#include <gtest/gtest.h>

#include "apps/reference/reference_mesh.h"
#include "sdk/splat/mesh_depth.h"
#include "tests/reference/mesh_depth_cases.h"

namespace dpl {
namespace {

std::vector<float> drawMesh(const MeshDepthCase& c, uint32_t threads = 2) {
    Jobs jobs(threads);
    MeshDepth mesh;
    std::vector<float> depthM(3, -1.0f);  // wrong size and content: draw must replace both
    mesh.draw(jobs, c.positions, c.triangles, c.camera, depthM);
    return depthM;
}

TEST(MeshDepth, refereeAgreesWithAPlaneByHand) {
    const std::vector<glm::dvec3> corners = {{-10, -10, 2}, {10, -10, 2}, {-10, 30, 4}};
    ReferenceCamera camera{100, 100, 50, 50, 50, 50, glm::dmat3(1), glm::dvec3(0)};
    const std::vector<glm::uvec3> triangle = {{0, 1, 2}};
    // z = 2 + (y + 10) / 20 on the ray (x, y, 1) t: t = 2 + (0.2 t + 10) / 20.
    EXPECT_NEAR(referenceMeshDepth(corners, triangle, camera, {50, 60}), 2.5 / 0.99, 1e-12);
    EXPECT_TRUE(std::isinf(referenceMeshDepth({}, {}, camera, {50, 60})));
}

TEST(MeshDepth, equalsTheReferenceInRandomAndHardCases) {
    size_t pixels = 0, sharp = 0;
    for (const MeshDepthCase& c : meshDepthCases()) {
        SCOPED_TRACE(c.name);
        const std::vector<float> depthM = drawMesh(c);
        ASSERT_EQ(depthM.size(), size_t(c.camera.widthPx) * c.camera.heightPx);
        const std::vector<glm::dvec3> positions(c.positions.begin(), c.positions.end());
        const MeshDepthReport r = compareMeshDepth(depthM, positions, c.triangles, referenceCamera(c.camera));
        EXPECT_EQ(r.wrong, 0u) << r.firstWrong;
        EXPECT_GE(double(r.covered), c.minCovered * double(r.pixels));
        EXPECT_LE(double(r.covered), c.maxCovered * double(r.pixels));
        pixels += r.pixels, sharp += r.sharp;
        for (const uint32_t threads : {1u, 3u}) EXPECT_EQ(drawMesh(c, threads), depthM) << threads << " threads";
    }
    EXPECT_GT(double(sharp), 0.9 * double(pixels)) << "the comparison says little";
    std::printf("%zu pixels, %.1f %% with one depth around their centre\n", pixels, 100 * double(sharp) / double(pixels));
}

TEST(MeshDepth, doesNotDependOnTheOrderOfTrianglesAndCorners) {
    MeshDepthCase c = meshDepthCases()[0];
    const std::vector<float> depthM = drawMesh(c);
    std::reverse(c.triangles.begin(), c.triangles.end());
    for (Triangle& t : c.triangles) t = {t.y, t.z, t.x};
    EXPECT_EQ(drawMesh(c), depthM);
}

}  // namespace
}  // namespace dpl
