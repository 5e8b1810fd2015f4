// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/garment_collision.h"
#include "reconstruction/subject/garments/priors.h"

#include <cstdio>

#include <gtest/gtest.h>

#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

constexpr float kPicture = 3e-4f;  // length of the picture's gradient on each garment vertex

/** The dressed ball, bent, with its garment partly inside the body. */
struct Bent {
    MeshData mesh = dressedBall(0);
    std::vector<JointData> joints = twoJoints();
    Pose pose = Pose::rest(2);
    std::vector<RestTriangle<float>> bind = restTriangles(mesh);
    std::vector<Vec3f> picture = std::vector<Vec3f>(mesh.restPositions.size(), Vec3f(0, kPicture, 0));
    GarmentCollision collision{mesh};
    PosedMesh posed;
    Jobs jobs{2};

    explicit Bent(float garmentRadiusM) {
        const uint32_t first = mesh.layers[1].firstVertex;
        for (uint32_t v = first; v < mesh.restPositions.size(); ++v)
            mesh.restPositions[v] *= garmentRadiusM * (1 + 0.03f * std::sin(7 * mesh.restPositions[v].x)) / 0.25f;
        pose.localRotations[1] = glm::angleAxis(0.4f, Vec3f(1, 0, 0));
    }
    double run(std::vector<Vec3f>& gradient, float factor = 1) {
        posed.pose({joints, mesh, {}, bind}, pose, jobs);
        return collision.pull(mesh, posed, picture, factor, jobs, gradient);
    }
};

TEST(GarmentCollision, aCentimetreInsidePullsAsHardAsThePicture) {
    Bent ball(0.25f);
    ball.pose = Pose::rest(2);
    const uint32_t pole = ball.mesh.layers[1].firstVertex;  // the garment's north pole is above the body's
    ball.mesh.restPositions[pole] = ball.mesh.restPositions[0] - Vec3f(0, 0.01f - priors::kClothClearanceM, 0);
    std::vector<Vec3f> gradient;
    ball.run(gradient);
    EXPECT_NEAR(glm::length(gradient[pole]), kPicture, 0.02f * kPicture);
    EXPECT_LT(gradient[pole].y, 0) << "a step against the gradient leads outwards";
    ball.run(gradient, 4);
    EXPECT_NEAR(glm::length(gradient[pole]), 4 * kPicture, 0.08f * kPicture);
    for (Vec3f& g : ball.picture) g = Vec3f(0);
    EXPECT_EQ(ball.run(gradient), 0) << "without a picture there is no unit";
}

TEST(GarmentCollision, gradientIsThatOfTheEnergyAndLeavesTheBodyAlone) {
    Bent ball(0.199f);
    std::vector<Vec3f> gradient, unused;
    ASSERT_GT(ball.run(gradient), 0);
    const uint32_t first = ball.mesh.layers[1].firstVertex;
    for (uint32_t v = 0; v < first; ++v) ASSERT_EQ(gradient[v], Vec3f(0)) << "vertex " << v << " of the body";
    const ClosestSurface body(ball.posed.positions(), std::span(ball.mesh.triangles).first(ball.mesh.layers[0].triangleCount));
    size_t compared = 0;
    for (uint32_t v = first; v < gradient.size(); v += 3) {
        constexpr float kStep = 2e-4f;
        if (glm::length(gradient[v]) < 2 * kStep * kPicture / 0.01f) continue;  // within a step of the clearance, where the energy begins
        for (int a = 0; a < 3; ++a) {
            const Vec3f at = ball.mesh.restPositions[v];
            double energy[2];
            uint32_t nearest[2];
            for (const int side : {0, 1}) {
                ball.mesh.restPositions[v][a] = at[a] + (side ? kStep : -kStep);
                energy[side] = ball.run(unused);
                nearest[side] = body.find(ball.posed.positions()[v]).triangle;
            }
            ball.mesh.restPositions[v] = at;
            if (nearest[0] != nearest[1]) continue;  // the distance has a kink between two triangles
            ++compared;
            EXPECT_NEAR((energy[1] - energy[0]) / (2 * kStep), gradient[v][a], 0.03 * glm::length(gradient[v]) + 1e-7) << "vertex " << v;
        }
    }
    EXPECT_GT(compared, 100u);
}

TEST(GarmentCollision, aGarmentInsideComesOut) {
    Bent ball(0.19f);
    std::vector<Vec3f> gradient;
    const double before = ball.run(gradient);
    for (int step = 0; step < 200; ++step) {
        ball.run(gradient);
        for (size_t v = 0; v < gradient.size(); ++v) ball.mesh.restPositions[v] -= 0.005f / kPicture * gradient[v];
    }
    EXPECT_GT(before, 0);
    EXPECT_LT(ball.run(gradient), 1e-4 * before);
    const ClosestSurface body(ball.posed.positions(), std::span(ball.mesh.triangles).first(ball.mesh.layers[0].triangleCount));
    for (size_t v = ball.mesh.layers[1].firstVertex; v < gradient.size(); ++v)
        ASSERT_GT(body.signedDistance(ball.posed.positions()[v], 1), 0.5f * priors::kClothClearanceM) << "vertex " << v;
}

TEST(GarmentCollision, whatIsOutsideOrHasNoGarmentIsNotPulled) {
    Bent ball(0.25f);
    std::vector<Vec3f> gradient;
    EXPECT_EQ(ball.run(gradient), 0);
    for (const Vec3f& g : gradient) ASSERT_EQ(g, Vec3f(0));
    EXPECT_FALSE(ball.collision.empty());
    EXPECT_TRUE(GarmentCollision(ballMesh()).empty());
}

/** Garment vertices inside the body, with its upper half bent forwards, after training on pictures of the ball at rest. The garment fits
 *  closely and follows the lower half alone. */
size_t insideWhenBent(bool stressed) {
    Jobs jobs(2);
    CoOptimiseInput input = toyScene(jobs, 4);
    input.mesh = dressedBall(0);
    input.joints[1].restPosition = {0, -0.1f, 0};
    for (uint32_t v = input.mesh.layers[1].firstVertex; v < input.mesh.restPositions.size(); ++v) {
        input.mesh.restPositions[v] *= 0.204f / 0.25f;
        input.mesh.jointIndices[v] = {0, 0, 0, 0}, input.mesh.jointWeights[v] = {255, 0, 0, 0};
    }
    Pose bent = Pose::rest(2);
    bent.localRotations[1] = glm::angleAxis(0.15f, Vec3f(1, 0, 0));
    if (stressed) input.stress = {bent};
    const std::vector<JointData> joints = input.joints;
    MeshData mesh = input.mesh;
    CoOptimiseSettings settings;
    settings.steps = 200, settings.init.splatCount = 800, settings.init.shDegree = 0, settings.densify = false;
    settings.learnPoses = settings.learnCorrectives = false;
    auto trainer = CoOptimiser::create(std::move(input), settings, jobs);
    if (!trainer || !(*trainer)->run()) throw std::runtime_error("the toy scene does not train");
    mesh.restPositions = (*trainer)->result().restPositions;
    PosedMesh posed;
    const std::vector<RestTriangle<float>> bind = restTriangles(mesh);
    posed.pose({joints, mesh, {}, bind}, bent, jobs);
    const ClosestSurface body(posed.positions(), std::span(mesh.triangles).first(mesh.layers[0].triangleCount));
    size_t inside = 0;
    for (size_t v = mesh.layers[1].firstVertex; v < mesh.restPositions.size(); ++v)
        inside += body.signedDistance(posed.positions()[v], 0.05f) < 0;
    return inside;
}

TEST(GarmentCollision, trainingPullsGarmentsOutInStressPosesThatNoPictureShows) {
    const size_t without = insideWhenBent(false), with = insideWhenBent(true);
    std::printf("garment vertices inside in the stress pose: %zu without it, %zu with it\n", without, with);
    EXPECT_GT(without, 50u) << "the case must be hard";
    EXPECT_LT(with, 0.75 * double(without));
}

TEST(GarmentCollision, isTheSameForAnyNumberOfThreads) {
    Bent one(0.195f), three(0.195f);
    std::vector<Vec3f> first, second;
    Jobs single(1);
    one.posed.pose({one.joints, one.mesh, {}, one.bind}, one.pose, single);
    const double energy = one.collision.pull(one.mesh, one.posed, one.picture, 1, single, first);
    EXPECT_EQ(three.run(second), energy);
    EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace dpl::test
