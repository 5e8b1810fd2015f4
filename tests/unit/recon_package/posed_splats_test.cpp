// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/posed_splats.h"

#include <gtest/gtest.h>

#include <random>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/math/binding.h"
#include "sdk/math/sh.h"
#include "sdk/splat/posed_splats.h"
#include "tests/unit/format/sample_correctives.h"

namespace {

using namespace dpl;

/** One triangle with three splats of SH degree 3. It is skinned to two joints, so that a pose shears and turns it. */
AvatarData oneTriangle() {
    AvatarData a;
    a.joints = {{"root", -1, Vec3f(0)}, {"tip", 0, Vec3f(0, 0.1f, 0)}};
    a.mesh.restPositions = {{0, 0, 0}, {0.1f, 0, 0.01f}, {0.02f, 0.12f, 0}};
    a.mesh.triangles = {{0, 1, 2}};
    a.mesh.jointIndices = {{0, 1, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0}};
    a.mesh.jointWeights = {{255, 0, 0, 0}, {200, 55, 0, 0}, {20, 235, 0, 0}};
    a.mesh.colours.assign(3, glm::u8vec4(255));
    a.mesh.layers = {{"body", "body", 0, 3, 0, 1}};
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, 1);
    a.splats.triangleStart = {0, 3};
    a.splats.shDegree = 3;
    for (int i = 0; i < 3; ++i) {
        a.splats.uv.push_back({0.2f + 0.1f * i, 0.3f});
        a.splats.phi.push_back(unit(random) * 3);
        a.splats.scaleM.push_back({0.004f + 0.01f * unit(random), 0.002f});
        a.splats.opacity.push_back(0.8f);
        a.splats.flags.push_back(0);
        for (int k = 0; k < 48; ++k) a.splats.sh.push_back(unit(random) - 0.5f);
    }
    return a;
}

Pose bentPose() {
    Pose pose = Pose::rest(2);
    pose.localRotations[0] = glm::angleAxis(0.7f, glm::normalize(Vec3f(1, 2, 0.5f)));
    pose.localRotations[1] = glm::angleAxis(-0.9f, glm::normalize(Vec3f(0.2f, 1, 1)));
    pose.rootTranslation = {0.3f, 1, -2};
    return pose;
}

struct Posed {
    AvatarData avatar = oneTriangle();
    TriangleFrame<float> frame;
    StaticSplatData out;
    Posed() {
        const Pose pose = bentPose();
        std::vector<Mat3x4f> worldFromRest;
        jointTransforms(avatar.joints, pose, worldFromRest);
        Jobs jobs(1);
        std::vector<Vec3f> positions;
        skin(avatar.mesh, worldFromRest, jobs, positions);
        std::vector<TriangleFrame<float>> frames;
        poseTriangles(avatar.mesh, {}, positions, jobs, frames);
        frame = frames[0];
        auto splats = posedSplats(avatar, pose);
        EXPECT_TRUE(splats);
        out = *splats;
    }
};

TEST(PosedSplats, covarianceIsThatOfTheBoundSplatPlusItsThickness) {
    Posed p;
    ASSERT_EQ(p.out.count(), 3u);
    const float thin = EllipseFormulas<float>::flatThicknessM();
    for (uint32_t i = 0; i < 3; ++i) {
        Vec3f a1, a2;
        splatAxes(p.frame, p.avatar.splats.phi[i], p.avatar.splats.scaleM[i].x, p.avatar.splats.scaleM[i].y, a1, a2);
        const Mat3f expected =
            glm::outerProduct(a1, a1) + glm::outerProduct(a2, a2) + thin * thin * glm::outerProduct(p.frame.normal, p.frame.normal);
        const Mat3f r = glm::mat3_cast(p.out.rotation[i]);
        Mat3f scaled = r;
        for (int k = 0; k < 3; ++k) scaled[k] *= p.out.scaleM[i][k];
        const Mat3f actual = scaled * glm::transpose(scaled);
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k)
                EXPECT_NEAR(actual[c][k], expected[c][k], 1e-9f);  // covariances are about 1e-4 m², float rounding about 1e-10
    }
}

TEST(PosedSplats, coloursSeenInTheWorldAreThoseOfTheRestFrame) {
    Posed p;
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    bool anyDiffers = false;
    for (int trial = 0; trial < 50; ++trial) {
        const Vec3f d = glm::normalize(Vec3f(normal(random), normal(random), normal(random)));
        for (uint32_t i = 0; i < 3; ++i) {
            float world[16], rest[16];
            shBasis(d, 3, world);
            shBasis(glm::transpose(p.frame.worldFromRest) * d, 3, rest);
            for (int channel = 0; channel < 3; ++channel) {
                float a = 0, b = 0, unturned = 0;
                for (int k = 0; k < 16; ++k) {
                    a += world[k] * p.out.sh[i * 48 + k * 3 + channel];
                    b += rest[k] * p.avatar.splats.sh[i * 48 + k * 3 + channel];
                    unturned += world[k] * p.avatar.splats.sh[i * 48 + k * 3 + channel];
                }
                EXPECT_NEAR(a, b, 2e-5f);  // float sums of 16 products of about 1
                anyDiffers |= std::abs(unturned - b) > 0.1f;
            }
        }
    }
    EXPECT_TRUE(anyDiffers) << "the pose does not turn the triangle: this test would prove nothing";
}

TEST(PosedSplats, offsetsMoveThemAndLightIsFoldedIntoTheirSh) {
    AvatarData avatar = oneTriangle();
    avatar.correctives = test::randomCorrectives(avatar, 4, {.modes = 2, .nodes = 3, .offsetM = 0.01f, .light = 0.8f});
    const Pose pose = bentPose();
    auto plain = posedSplats(oneTriangle(), pose), corrected = posedSplats(avatar, pose);
    ASSERT_TRUE(plain && corrected);
    Jobs jobs(1);
    const auto bind = restTriangles(avatar.mesh);
    PosedMesh mesh;
    mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, bind}, pose, jobs);
    const TriangleFrame<float>& frame = mesh.frames()[0];
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    float furthestFromOne = 0;
    for (uint32_t i = 0; i < 3; ++i) {
        EXPECT_LT(glm::length(corrected->position[i] - splatCentre(frame, avatar.splats.uv[i])), 1e-7f);
        EXPECT_GT(glm::length(corrected->position[i] - plain->position[i]), 1e-3f);
        const float light = splatLight(frame, avatar.splats.uv[i]);
        furthestFromOne = std::max(furthestFromOne, std::abs(light - 1));
        for (int trial = 0; trial < 20; ++trial) {
            const Vec3f d = glm::normalize(Vec3f(normal(random), normal(random), normal(random)));
            // A viewer without correctives must show the same colour as Doppel, clamps included.
            const Vec3f shown = shColour(&corrected->sh[i * 48], 3, d),
                        meant = shColour(&avatar.splats.sh[i * 48], 3, glm::transpose(frame.worldFromRest) * d, light);
            EXPECT_LT(glm::length(shown - meant), 3e-5f);
        }
    }
    EXPECT_GT(furthestFromOne, 0.1f) << "this test would prove nothing";
}

TEST(PosedSplats, aPoseThatIsNotFiniteIsRefusedByJointName) {
    Pose pose = bentPose();
    pose.localRotations[1].x = std::nanf("");
    auto splats = posedSplats(oneTriangle(), pose);
    ASSERT_FALSE(splats);
    EXPECT_NE(splats.error().message.find("tip"), std::string::npos);
}

}  // namespace
