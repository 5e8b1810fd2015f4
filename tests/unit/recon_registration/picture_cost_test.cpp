// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/picture_cost.h"

#include <gtest/gtest.h>

#include "reconstruction/subject/registration/appearance.h"
#include "tests/unit/cost_gradient.h"
#include "tests/unit/recon_registration/painted_scene.h"

namespace dpl::test {
namespace {

/** A smooth picture and a smooth distance field, so that finite differences of bilinear samples are good. */
struct CostCase {
    CostCase() {
        camera = cameraAround(0.3);
        contrast.widthPx = camera.widthPx, contrast.heightPx = camera.heightPx;
        outline.widthPx = camera.widthPx, outline.heightPx = camera.heightPx;
        for (uint32_t y = 0; y < camera.heightPx; ++y)
            for (uint32_t x = 0; x < camera.widthPx; ++x) {
                contrast.values.push_back({0.002f * float(x), 0.001f * float(y) - 0.001f * float(x), 0.0015f * float(y)});
                contrast.inside.push_back(1);
                outline.distancePx.push_back(0.3f * float(x) - 0.2f * float(y));
            }
    }
    PictureCost cost(bool points, bool edges) {
        std::vector<ContrastTerm> a;
        std::vector<OutlineTerm> b;
        const std::vector<MeshPoint> all = spreadPoints(scene.mesh, 60);
        for (size_t i = 0; i < all.size(); ++i) {
            const CarriedPoint point(scene.body.joints, scene.mesh, all[i]);
            if (points) a.push_back({point, Vec3d(0.2, 0.03 * double(i % 3), 0.15), 0.1, 0.4});
            if (edges) b.push_back({point, &outline, 0.05, 0.3});
        }
        return PictureCost(chain, camera, rotationOf({0, 0.2, 0}), &contrast, std::move(a), std::move(b));
    }
    PaintedScene scene{0};
    Camerad camera;
    ContrastImage contrast;
    MaskDistance outline{0, 0, 1, {}};
    KeypointChain chain{scene.body, scene.names, {1, 2, 4, 7, 8, 9, 11, 12}};
};

void expectRightGradient(const PictureCost& cost, size_t columns) {
    std::vector<double> x(columns, 0.0);
    for (size_t i = 0; i < columns; ++i) x[i] = 0.05 * std::sin(double(i));
    const std::vector<double> gradient = test::expectGradient(cost, x, 1e-3);  // float pictures: measured 2e-5
    EXPECT_GT(test::halfCost(cost, x), 0.1);
    for (size_t i = 0; i < kRootSize; ++i) EXPECT_NE(gradient[i], 0) << i;
}

TEST(PictureCost, gradientOfContrastIsThatOfFiniteDifferences) {
    CostCase c;
    expectRightGradient(c.cost(true, false), c.chain.columns());
}

TEST(PictureCost, gradientOfOutlinesIsThatOfFiniteDifferences) {
    CostCase c;
    expectRightGradient(c.cost(false, true), c.chain.columns());
}

TEST(PictureCost, pointsBehindTheCameraAreConstant) {
    CostCase c;
    const PictureCost cost = c.cost(true, true);
    std::vector<double> x(c.chain.columns(), 0.0), gradient;
    x[5] = 50;  // far behind the eye
    test::halfCost(cost, x, &gradient);
    for (const double g : gradient) EXPECT_NEAR(g, 0, 1e-9);
}

TEST(CarriedPoint, movesAsSkinningMovesIt) {
    PaintedScene scene(1);
    KeypointChain chain(scene.body, scene.names, {1, 2, 4, 7, 8, 9, 11, 12});
    KeypointChain::Output posed;
    std::vector<double> pose(3 * chain.posedCount(), 0.1), root(kRootSize, 0.1);
    chain.evaluate(Mat3d(1.0), root.data(), pose.data(), nullptr, false, posed);
    Pose same = Pose::rest(scene.body.joints.size());
    same.localRotations[0] = Quatf(glm::quat_cast(rotationOf({0.1, 0.1, 0.1})));
    same.rootTranslation = Vec3f(0.1f);
    for (const uint32_t j : chain.posedJoints()) same.localRotations[j] = same.localRotations[0];
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(scene.body.joints, same, worldFromRest);
    for (const MeshPoint& p : spreadPoints(scene.mesh, 50)) {
        const Triangle& t = scene.mesh.triangles[p.triangle];
        Vec3f place(0);
        const float weight[3] = {1 - p.uv.x - p.uv.y, p.uv.x, p.uv.y};
        for (int k = 0; k < 3; ++k)
            place += weight[k] * (worldFromRest[scene.mesh.jointIndices[t[k]][0]] * Vec4f(scene.mesh.restPositions[t[k]], 1));
        EXPECT_LT(glm::length(CarriedPoint(scene.body.joints, scene.mesh, p).place(posed) - Vec3d(place)), 1e-5);
    }
}

}  // namespace
}  // namespace dpl::test
