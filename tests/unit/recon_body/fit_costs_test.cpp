// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/fit_costs.h"

#include "small_body.h"
#include "tests/unit/cost_gradient.h"

namespace dpl {
namespace {

JointPrior priorOf(double accelerationRadS2) {
    JointPrior prior;
    prior.accelerationRadS2 = accelerationRadS2;
    return prior;
}

/** The small body before a camera, with keypoints that lie a few pixels from where it shows them, and one far off. */
struct CostCase {
    BodyModel body = smallBody();
    std::vector<std::string> names{scanKeypointNames().begin(), scanKeypointNames().end()};
    KeypointChain chain{body, names, {1, 4, 7}};
    FitContext context;
    Camerad camera;
    std::vector<Keypoint> keypoints;

    CostCase() {
        context.chain = &chain;
        context.sway.slots = {0, 2};
        camera.widthPx = 378, camera.heightPx = 504, camera.fx = camera.fy = 380, camera.cx = 189, camera.cy = 252;
        camera.viewFromWorldRotation = Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1);
        camera.viewFromWorldTranslation = {0, 0.9, 2.5};
        KeypointChain::Output posed;
        const std::vector<double> zero(chain.columns(), 0.0);
        chain.evaluate(Mat3d(1.0), zero.data(), zero.data(), zero.data(), false, posed);
        for (size_t k = 0; k < names.size(); ++k) {
            const Vec2d px = camera.pixelOf(camera.toView(posed.points[k]));
            keypoints.push_back({px + Vec2d(k % 3, k % 5) + (k == 4 ? Vec2d(60, -40) : Vec2d(0)), chain.hasKeypoint(k) ? 0.8 : 0.0});
        }
    }
    static std::vector<double> somewhere(const ceres::CostFunction& cost) {
        std::vector<double> x;
        for (const int size : cost.parameter_block_sizes())
            for (int i = 0; i < size; ++i) x.push_back(0.05 * std::sin(1.3 * double(x.size()) + 0.4));
        return x;
    }
};

size_t entriesNotZero(const std::vector<double>& gradient) {
    return size_t(std::count_if(gradient.begin(), gradient.end(), [](double g) { return g != 0; }));
}

TEST(FitCosts, reprojectionHasTheGradientOfItsCost) {
    const CostCase c;
    for (const bool sways : {false, true}) {
        const ReprojectionCost cost(c.context, c.camera, rotationOf({0, 0.2, 0}), c.keypoints, 2, sways);
        const auto gradient = test::expectGradient(cost, CostCase::somewhere(cost));
        EXPECT_GT(entriesNotZero(gradient), gradient.size() / 2) << sways;
    }
}

TEST(FitCosts, standingFeetHaveTheGradientOfTheirCost) {
    const CostCase c;
    std::vector<size_t> known;
    for (size_t k = 0; k < c.names.size(); ++k)
        if (c.chain.hasKeypoint(k)) known.push_back(k);
    const FootRest cost(c.context, known, rotationOf({0, 0.2, 0}), rotationOf({0.1, 0.1, 0}), 0.01);
    const auto gradient = test::expectGradient(cost, CostCase::somewhere(cost));
    EXPECT_GT(entriesNotZero(gradient), gradient.size() / 2);
}

TEST(FitCosts, aJointsPriorHasTheGradientOfItsCostWithinItsRangeAndBeyond) {
    JointPrior prior = priorOf(1);
    const Mat3d turned = rotationOf({0.3, 0.5, -0.2});
    for (int a = 0; a < 3; ++a)
        prior.axes[a] = turned[a], prior.sigmaRad[a] = 0.2 + 0.1 * a, prior.lowRad[a] = -0.2, prior.highRad[a] = 0.3;
    prior.tailSigmas[1] = 2;
    const JointPriorCost cost(prior, {0.1, -0.05, 0.2});
    for (const double size : {0.1, 0.9}) EXPECT_EQ(entriesNotZero(test::expectGradient(cost, {size, -0.7 * size, 0.4 * size})), 3u);
}

TEST(FitCosts, accelerationsWithAHeavyTailHaveTheGradientOfTheirCost) {
    const JointSmoothness cost(priorOf(2), 0, 0.2, 0.45, {true, 0.2});
    const std::vector<double> x{0.1, 0, -0.2, 0.3, 0.01, 0.1, -0.1, 0, 0.4};
    EXPECT_GT(test::halfCost(cost, x), 1) << "in the tail";
    EXPECT_EQ(entriesNotZero(test::expectGradient(cost, x)), 9u);
}

}  // namespace
}  // namespace dpl
