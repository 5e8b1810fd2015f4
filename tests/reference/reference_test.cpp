// SPDX-License-Identifier: Apache-2.0
// The referee has tests of its own: closed forms, and determinants in long double.
#include "apps/reference/reference_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/reference/image_compare.h"

namespace dpl {
namespace {

ReferenceCamera camera(uint32_t size, double focal) {
    return {size, size, focal, focal, size / 2.0, size / 2.0, glm::dmat3(1), glm::dvec3(0)};
}

ReferenceGaussian disc(const glm::dvec3& centre, double radius, double opacity) {
    ReferenceGaussian g;
    g.centre = centre;
    g.axes[0] = {radius, 0, 0}, g.axes[1] = {0, radius, 0};
    g.opacity = opacity;
    g.sh = {0, 0, 0};
    return g;
}

TEST(Reference, frontalDiscHasTheVarianceOfTheTextbook) {
    const ReferenceFootprint f = projectReference(disc({0, 0, 2}, 0.1, 0.8), camera(100, 200), {});
    ASSERT_TRUE(f.visible);
    EXPECT_NEAR(f.covariance[0][0], 100 + 0.3, 1e-9);  // (200·0.1/2)² + κ
    EXPECT_NEAR(f.covariance[0][1], 0, 1e-12);
    EXPECT_NEAR(f.compensation, 100 / 100.3, 1e-12);
    EXPECT_NEAR(f.opacity, 0.8 * 100 / 100.3, 1e-12);
    EXPECT_NEAR(referenceAlpha(f, {50 + std::sqrt(100.3), 50}), f.opacity * std::exp(-0.5), 1e-12);
    EXPECT_NEAR(f.colour.x, 0.5, 1e-15);
}

TEST(Reference, twoLayersBlendFrontToBack) {
    // The image has an odd size, so σ is 0 in its middle pixel for both splats.
    ReferenceGaussian front = disc({0, 0, 1}, 10, 0.5), back = disc({0, 0, 2}, 10, 0.5);
    front.sh = {10, -10, -10}, back.sh = {-10, 10, -10};
    const ReferenceImage image = renderReference({back, front}, camera(3, 1), {.kappaPx2 = 0});
    const size_t middle = 4;
    EXPECT_NEAR(image.rgb[middle * 3], 0.5, 1e-12);
    EXPECT_NEAR(image.rgb[middle * 3 + 1], 0.25, 1e-12);
    EXPECT_NEAR(image.alpha[middle], 0.75, 1e-12);
    EXPECT_NEAR(image.depthM[middle], (0.5 * 1 + 0.25 * 2) / 0.75, 1e-12);
}

TEST(Reference, determinantMatchesLongDoubleOnNeedles) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 500; ++i) {
        ReferenceGaussian g = disc({0.2 * normal(random), 0.2 * normal(random), 2}, 1, 1);
        g.axes[0] = 0.5 * glm::dvec3(normal(random), normal(random), normal(random));
        g.axes[1] = 1e-4 * glm::dvec3(normal(random), normal(random), normal(random));
        const ReferenceFootprint f = projectReference(g, camera(400, 1000), {});
        const long double a = f.covariance[0][0], b = f.covariance[0][1], c = f.covariance[1][1];
        const double product = double(a / (a * c - b * b));
        // The entries of Σ' are rounded to double, so the subtraction itself is good to eps·a·c/det ≈ 1e-16·1e6.
        EXPECT_NEAR(f.conic[1][1] / product, 1, 1e-8);
    }
}

TEST(Reference, bindingReproducesRestWhenNotPosed) {
    ReferenceScene scene;
    scene.rest = scene.posed = {{0.1, 0.2, 0.3}, {0.2, 0.25, 0.3}, {0.12, 0.31, 0.36}};
    scene.triangles = {{0, 1, 2}};
    const ReferenceBoundSplat s{0, {0.25, 0.5}, 0, {0.01, 0.02}, 0.5, 0, {0, 0, 0}};
    const ReferenceGaussian g = referenceGaussian(scene, s);
    ASSERT_TRUE(g.valid);
    EXPECT_NEAR(glm::length(g.axes[0]), 0.01, 1e-14);
    EXPECT_NEAR(glm::length(g.axes[1]), 0.02, 1e-14);
    EXPECT_NEAR(glm::dot(g.axes[0], g.axes[1]), 0, 1e-16);
    EXPECT_NEAR(glm::length(glm::cross(g.axes[0], scene.rest[1] - scene.rest[0])), 0, 1e-16);  // φ = 0 lies along e1
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) EXPECT_NEAR(g.worldFromRest[c][r], c == r ? 1 : 0, 1e-12);
}

TEST(Reference, rigidMotionTurnsAxesAndRotationAlike) {
    const glm::dmat3 turn(glm::mat3_cast(glm::dquat(0.5, 0.5, -0.5, 0.5)));
    ReferenceScene scene;
    scene.rest = {{0, 0, 0}, {0.1, 0, 0}, {0.02, 0.1, 0}};
    for (const glm::dvec3& p : scene.rest) scene.posed.push_back(turn * p + glm::dvec3(1, 2, 3));
    scene.triangles = {{0, 1, 2}};
    const ReferenceGaussian g = referenceGaussian(scene, {0, {0.2, 0.2}, 0.3, {0.01, 0.02}, 0.5, 0, {0, 0, 0}});
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(glm::length(g.worldFromRest[c] - turn[c]), 0, 1e-12);
}

TEST(Reference, jointTurnsAboutItsRestPosition) {
    AvatarData avatar;
    avatar.joints = {{"root", -1, Vec3f(0, 1, 0), ""}, {"child", 0, Vec3f(0, 2, 0), ""}};
    avatar.mesh.restPositions = {Vec3f(0, 3, 0)};
    avatar.mesh.jointIndices = {{1, 0, 0, 0}};
    avatar.mesh.jointWeights = {{255, 0, 0, 0}};
    Pose pose = Pose::rest(2);
    const float half = std::sqrt(0.5f);
    pose.localRotations[1] = Quatf(half, 0, 0, half);  // a quarter turn about +z: +y goes to −x
    pose.rootTranslation = Vec3f(0, 0, 5);
    const glm::dvec3 p = referenceSkin(avatar, pose)[0];
    EXPECT_NEAR(p.x, -1, 1e-7);
    EXPECT_NEAR(p.y, 2, 1e-7);
    EXPECT_NEAR(p.z, 5, 1e-7);
}

AvatarData correctedPoint() {
    AvatarData avatar;
    avatar.joints = {{"root", -1, Vec3f(0, 0, 0), ""}, {"child", 0, Vec3f(0, 2, 0), ""}};
    avatar.mesh.restPositions = {Vec3f(0, 3, 0)};
    avatar.mesh.jointIndices = {{0, 0, 0, 0}}, avatar.mesh.jointWeights = {{255, 0, 0, 0}};
    PoseCorrectiveData& c = avatar.correctives;
    c.modeCount = 2, c.nodeCount = 2, c.reach = 10;
    c.joints = {1}, c.mean = {0, 0.5f, 0, 0, 0, 0};
    c.modes = {1, 2, 0, 0, 0, 0, 0, 0, 0, 0, -3, 0};
    c.nodeIndices = {{1, 0, 0, 0}}, c.nodeWeights = {{204, 51, 0, 0}};  // 0.8 and 0.2
    c.nodes = {{0.1f, 0, 0, 1}, {0, 0.2f, 0, 0}, {0, 0, 0.05f, 0}, {0, 0, 0, -0.25f}};
    return avatar;
}

Pose quarterTurnOfTheChild() {
    Pose pose = Pose::rest(2);
    const float half = std::sqrt(0.5f);
    pose.localRotations[1] = Quatf(half, 0, 0, half);  // features: −1, 1, 0, −1, −1, 0
    return pose;
}

TEST(Reference, correctivesFollowTheirFormula) {
    AvatarData avatar = correctedPoint();
    const Pose pose = quarterTurnOfTheChild();
    std::vector<double> k = referenceCoefficients(avatar.correctives, pose).k;
    EXPECT_NEAR(k[0], -1 + 2 * (1 - 0.5), 1e-7);
    EXPECT_NEAR(k[1], 3, 1e-7);
    avatar.correctives.mean[1] = 0;
    k = referenceCoefficients(avatar.correctives, pose).k;  // (1, 3)
    EXPECT_NEAR(k[0], 1, 1e-7);
    const ReferenceCorrection whole = referenceCorrection(avatar, pose);
    EXPECT_NEAR(glm::length(whole.offset[0] - glm::dvec3(0.2 * 0.1, 0.2 * 3 * 0.2, 0.8 * 0.05)), 0, 1e-7);
    EXPECT_NEAR(whole.light[0], 1 + 0.2 * 1 - 0.8 * 3 * 0.25, 1e-7);
    EXPECT_NEAR(glm::length(referenceSkin(avatar, pose)[0] - glm::dvec3(0, 3, 0) - whole.offset[0]), 0, 1e-7);
    avatar.correctives.reach = std::sqrt(10.0f) / 2;  // half of ‖k‖
    const ReferenceCorrection half = referenceCorrection(avatar, pose);
    EXPECT_NEAR(glm::length(half.offset[0] - 0.5 * whole.offset[0]), 0, 1e-7);
    EXPECT_NEAR(half.light[0], 1 + 0.5 * (whole.light[0] - 1), 1e-7);
    // Features (−1, 1, 0, −1, −1, 0) on modes along (1, 2, 0 ...) and −e5: 4 − 1/5 − 1 is left.
    avatar.correctives.reach = 10, avatar.correctives.reachOffModes = float(std::sqrt(2.8) / 4);
    EXPECT_NEAR(glm::length(referenceCorrection(avatar, pose).offset[0] - 0.25 * whole.offset[0]), 0, 1e-7);
}

TEST(Reference, lightIsClampedThenMultipliesTheColourBeforeItsClamp) {
    AvatarData avatar = correctedPoint();
    for (const auto& [change, expected] : {std::pair{-40.0f, 3.0}, {40.0f, 0.2}}) {
        avatar.correctives.nodes[3].w = change, avatar.correctives.nodes[0].w = 0;
        avatar.correctives.modes[10] = 3;  // k_1 = −3
        EXPECT_EQ(referenceCorrection(avatar, quarterTurnOfTheChild()).light[0], expected);
    }
    ReferenceGaussian g = disc({0, 0, 2}, 0.1, 1);
    const double c0 = 1 / std::sqrt(4 * std::acos(-1.0));
    g.sh = {-0.1 / c0, 0.3 / c0, -0.7 / c0};  // 0.4, 0.8, −0.2
    g.light = 2;
    glm::dvec3 colour = projectReference(g, camera(10, 20), {}).colour;
    EXPECT_LT(glm::length(colour - glm::dvec3(0.8, 1, 0)), 1e-12);
    g.light = 0.5;
    colour = projectReference(g, camera(10, 20), {}).colour;
    EXPECT_LT(glm::length(colour - glm::dvec3(0.2, 0.4, 0)), 1e-12);
}

TEST(ImageCompare, knowsEqualDifferentAndBroken) {
    const std::vector<float> a = {0, 0.5f, 1}, b = {0, 0.6f, 1};
    EXPECT_TRUE(std::isinf(compareImages(a, a).psnrDb));
    EXPECT_NEAR(compareImages(a, b).psnrDb, -10 * std::log10(0.01 / 3), 1e-4);
    EXPECT_EQ(compareImages(a, b).worst, 1u);
    EXPECT_TRUE(std::isinf(compareImages(a, std::vector<float>{0}).maxError));
    EXPECT_TRUE(std::isinf(compareImages(a, std::vector<float>{0, NAN, 1}).maxError));
    EXPECT_NEAR(coverage(a), 2.0 / 3, 1e-12);
}

}  // namespace
}  // namespace dpl
