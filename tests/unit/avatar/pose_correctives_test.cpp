// SPDX-License-Identifier: Apache-2.0
// Pose correctives: coefficients, control nodes, interpolation at vertices; and PosedMesh, which uses them.
#include "sdk/avatar/pose_correctives.h"

#include <gtest/gtest.h>

#include "sdk/avatar/posed_mesh.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

/** Two joints, and a strip of triangles along +Y between them. */
AvatarData strip() {
    AvatarData a;
    a.joints = {{"root", -1, {0, 0, 0}, ""}, {"tip", 0, {0, 0.5f, 0}, ""}};
    for (uint32_t v = 0; v < 12; ++v) {
        a.mesh.restPositions.emplace_back(v % 2 ? 0.1f : 0.0f, 0.1f * float(v / 2), 0.02f * float(v % 3));
        a.mesh.jointIndices.emplace_back(0, 1, 0, 0);
        a.mesh.jointWeights.emplace_back(uint8_t(255 - 20 * v), uint8_t(20 * v), uint8_t(0), uint8_t(0));
        if (v >= 2) a.mesh.triangles.emplace_back(v - 2, v - 1, v);
    }
    return a;
}

Pose turned(float angle0, float angle1) {
    Pose pose = Pose::rest(2);
    pose.localRotations[0] = glm::angleAxis(angle0, glm::normalize(Vec3f(1, 2, -1)));
    pose.localRotations[1] = 2.0f * glm::angleAxis(angle1, glm::normalize(Vec3f(-1, 0.5f, 1)));  // unnormalised on purpose
    return pose;
}

float lengthOf(const std::vector<float>& k) {
    float sum = 0;
    for (const float x : k) sum += x * x;
    return std::sqrt(sum);
}

class PoseCorrectives : public testing::Test {
protected:
    AvatarData avatar_ = strip();
    PoseCorrectiveData c_ = test::randomCorrectives(avatar_, 3, {.modes = 4, .nodes = 5, .reach = 100});
    Jobs jobs_{2};

    std::vector<float> coefficients(const Pose& pose) {
        std::vector<float> k;
        correctiveCoefficients(c_, pose, k);
        return k;
    }
    void spread(const std::vector<Vec4f>& nodes, std::vector<Vec3f>& moved, std::vector<float>& light) {
        spreadCorrectives(c_, nodes, avatar_.mesh.restPositions, jobs_, moved, light);
    }
};

TEST_F(PoseCorrectives, theMeanPoseHasCoefficientsZero) {
    const Pose pose = turned(0.7f, -1.1f);
    EXPECT_GT(lengthOf(coefficients(pose)), 0.1f);
    for (size_t j = 0; j < c_.joints.size(); ++j) correctiveFeature(pose.localRotations[c_.joints[j]], &c_.mean[j * 6]);
    for (const float k : coefficients(pose)) EXPECT_EQ(k, 0.0f);
}

TEST_F(PoseCorrectives, aFeatureIsTwoColumnsOfTheRotationMinusTheIdentity) {
    float feature[6];
    correctiveFeature(3.0f * glm::angleAxis(glm::half_pi<float>(), Vec3f(0, 0, 1)), feature);
    const float expected[6] = {-1, 1, 0, -1, -1, 0};
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(feature[i], expected[i], 1e-6f) << i;
    correctiveFeature(Quatf(1, 0, 0, 0), feature);
    for (const float x : feature) EXPECT_EQ(x, 0.0f);
}

TEST_F(PoseCorrectives, onlyJointsOfTheFeatureCount) {
    c_.joints = {1}, c_.mean.resize(6), c_.modes.resize(4 * 6);
    EXPECT_EQ(coefficients(turned(0.3f, 0.9f)), coefficients(turned(-2, 0.9f)));
    EXPECT_NE(coefficients(turned(0.3f, 0.9f)), coefficients(turned(0.3f, 0.8f)));
    Pose moved = turned(0.3f, 0.9f);
    moved.rootTranslation = {5, 6, 7};
    EXPECT_EQ(coefficients(moved), coefficients(turned(0.3f, 0.9f)));
}

TEST_F(PoseCorrectives, longerPosesAreShortenedToReachAndKeepTheirDirection) {
    const Pose pose = turned(1.4f, -2);
    const std::vector<float> whole = coefficients(pose);
    const float length = lengthOf(whole);
    ASSERT_GT(length, 0.5f);
    c_.reach = 0.25f * length;
    std::vector<float> k;
    EXPECT_NEAR(correctiveCoefficients(c_, pose, k).length, length, 1e-5f * length);  // returns the length before shortening
    for (size_t i = 0; i < k.size(); ++i) EXPECT_NEAR(k[i], 0.25f * whole[i], 1e-6f);
    c_.reach = 1.01f * length;
    EXPECT_EQ(coefficients(pose), whole);
}

TEST_F(PoseCorrectives, fadeInProportionOffTheModesAndNotAlongThem) {
    c_.joints = {1}, c_.modeCount = 1;
    c_.mean.assign(6, 0.0f), c_.modes = {0, 0, 0, 0, 2, 0};  // reads R_yy − 1
    c_.nodes.resize(c_.nodeCount);
    Pose pose = Pose::rest(2);
    pose.localRotations[1] = glm::angleAxis(1.2f, Vec3f(0, 0, 1));  // features (cos − 1, sin, 0, −sin, cos − 1, 0)
    const float c1 = std::cos(1.2f) - 1, s = std::sin(1.2f), off = std::sqrt(c1 * c1 + 2 * s * s);
    std::vector<float> k;
    c_.reachOffModes = 1.01f * off;
    EXPECT_NEAR(correctiveCoefficients(c_, pose, k).offModes, off, 1e-5f);
    EXPECT_NEAR(k[0], 2 * c1, 1e-6f);
    c_.reachOffModes = 0.25f * off;
    correctiveCoefficients(c_, pose, k);
    EXPECT_NEAR(k[0], 0.5f * c1, 1e-6f);
}

TEST_F(PoseCorrectives, nodesAreLinearInTheCoefficients) {
    std::vector<Vec4f> a, b, both;
    correctiveNodes(c_, std::vector<float>{1, 0, -2, 0.5f}, a);
    correctiveNodes(c_, std::vector<float>{0, 3, 1, 0.25f}, b);
    correctiveNodes(c_, std::vector<float>{2, 3, -3, 1.25f}, both);
    ASSERT_EQ(both.size(), 5u);
    for (size_t n = 0; n < both.size(); ++n) EXPECT_LT(glm::length(both[n] - (2.0f * a[n] + b[n])), 1e-6f);
    correctiveNodes(c_, std::vector<float>{0, 1, 0, 0}, a);
    for (size_t n = 0; n < a.size(); ++n) EXPECT_EQ(a[n], c_.nodes[n * 4 + 1]);
}

/** Several nodes are summed at once. That must not change a bit, whether their number is a multiple of it or not. */
TEST_F(PoseCorrectives, eachNodeAddsItsModesInOrder) {
    const std::vector<float> k{0.7f, -1.3f, 0.11f, 2.9f};
    PoseCorrectiveData more = c_;
    for (more.nodeCount = 1; more.nodeCount <= 9; ++more.nodeCount) {
        more.nodes.clear();
        for (uint32_t i = 0; i < more.nodeCount * 4; ++i) more.nodes.push_back(c_.nodes[i % c_.nodes.size()] * (1 + 0.01f * float(i)));
        std::vector<Vec4f> nodes;
        correctiveNodes(more, k, nodes);
        ASSERT_EQ(nodes.size(), more.nodeCount);
        for (uint32_t n = 0; n < more.nodeCount; ++n) {
            Vec4f sum(0);
            for (uint32_t i = 0; i < 4; ++i) sum += k[i] * more.nodes[n * 4 + i];
            EXPECT_EQ(nodes[n], sum) << "node " << n << " of " << more.nodeCount;
        }
    }
}

TEST_F(PoseCorrectives, verticesFollowTheirNodesByWeight) {
    std::vector<Vec4f> nodes(5, Vec4f(0));
    nodes[1] = {0.01f, 0, 0, 0.5f}, nodes[4] = {0, -0.02f, 0.03f, -0.25f};
    c_.nodeIndices[0] = {1, 4, 0, 0}, c_.nodeWeights[0] = {51, 204, 0, 0};  // 0.2 and 0.8
    c_.nodeIndices[1] = {2, 3, 0, 0}, c_.nodeWeights[1] = {100, 155, 0, 0};
    std::vector<Vec3f> moved;
    std::vector<float> light;
    spread(nodes, moved, light);
    EXPECT_LT(glm::length(moved[0] - avatar_.mesh.restPositions[0] - Vec3f(0.002f, -0.016f, 0.024f)), 1e-7f);
    EXPECT_NEAR(light[0], 1 + 0.1f - 0.2f, 1e-6f);
    EXPECT_EQ(moved[1], avatar_.mesh.restPositions[1]);
    EXPECT_EQ(light[1], 1.0f);
}

TEST_F(PoseCorrectives, brightnessIsClampedAndOffsetsAreNot) {
    std::vector<Vec3f> moved;
    std::vector<float> light;
    spread(std::vector<Vec4f>(5, Vec4f(1, 0, 0, 7)), moved, light);
    for (size_t v = 0; v < light.size(); ++v) {
        EXPECT_EQ(light[v], kMaxLight);
        EXPECT_NEAR(moved[v].x, avatar_.mesh.restPositions[v].x + 1, 1e-6f);
    }
    spread(std::vector<Vec4f>(5, Vec4f(0, 0, 0, -7)), moved, light);
    for (const float l : light) EXPECT_EQ(l, kMinLight);
}

TEST_F(PoseCorrectives, sameBytesOnAnyThreadCount) {
    PoseCorrectiveData wide = c_;
    std::vector<Vec3f> rest(9000, Vec3f(0.1f, 0.2f, 0.3f)), one, three;
    wide.nodeIndices.clear(), wide.nodeWeights.clear();
    for (uint32_t v = 0; v < rest.size(); ++v)
        wide.nodeIndices.emplace_back(v % 5, (v + 1) % 5, (v + 2) % 5, 0), wide.nodeWeights.emplace_back(v % 200, 50, 5, 200 - v % 200);
    std::vector<Vec4f> nodes;
    correctiveNodes(wide, std::vector<float>{1, -1, 0.3f, 2}, nodes);
    std::vector<float> light1, light3;
    Jobs jobs1(1), jobs3(3);
    spreadCorrectives(wide, nodes, rest, jobs1, one, light1);
    spreadCorrectives(wide, nodes, rest, jobs3, three, light3);
    EXPECT_EQ(one, three);
    EXPECT_EQ(light1, light3);
}

TEST_F(PoseCorrectives, posedMeshSkinsTheMovedSurfaceAndHandsLightToTheCorners) {
    const Pose pose = turned(0.4f, -0.9f);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar_.mesh);
    PosedMesh plain, corrected;
    plain.pose({avatar_.joints, avatar_.mesh, {}, bind}, pose, jobs_);
    corrected.pose({avatar_.joints, avatar_.mesh, c_, bind}, pose, jobs_);
    ASSERT_EQ(corrected.light().size(), avatar_.mesh.restPositions.size());
    EXPECT_TRUE(plain.light().empty());

    std::vector<Vec4f> nodes;
    correctiveNodes(c_, coefficients(pose), nodes);
    std::vector<Vec3f> moved, expected;
    std::vector<float> light;
    spread(nodes, moved, light);
    skin(avatar_.mesh, moved, plain.worldFromRest(), jobs_, expected);
    for (size_t v = 0; v < expected.size(); ++v) {
        EXPECT_EQ(corrected.positions()[v], expected[v]);
        EXPECT_NE(corrected.positions()[v], plain.positions()[v]);
    }
    for (size_t t = 0; t < bind.size(); ++t) {
        const Triangle& corner = avatar_.mesh.triangles[t];
        EXPECT_EQ(corrected.frames()[t].light, Vec3f(light[corner.x], light[corner.y], light[corner.z]));
        EXPECT_EQ(plain.frames()[t].light, Vec3f(1));
        EXPECT_EQ(corrected.frames()[t].v0, expected[corner.x]);
    }
    EXPECT_NEAR(splatLight(corrected.frames()[0], {0.25f, 0.5f}), 0.25f * light[0] + 0.25f * light[1] + 0.5f * light[2], 1e-6f);
}

TEST_F(PoseCorrectives, aPosedMeshForgetsTheCorrectivesOfTheSubjectBefore) {
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar_.mesh);
    PosedMesh fresh, reused;
    reused.pose({avatar_.joints, avatar_.mesh, c_, bind}, turned(1, 1), jobs_);
    reused.pose({avatar_.joints, avatar_.mesh, {}, bind}, turned(0.2f, 0.1f), jobs_);
    fresh.pose({avatar_.joints, avatar_.mesh, {}, bind}, turned(0.2f, 0.1f), jobs_);
    for (size_t v = 0; v < fresh.positions().size(); ++v) EXPECT_EQ(fresh.positions()[v], reused.positions()[v]);
    EXPECT_EQ(reused.frames()[0].light, Vec3f(1));
    EXPECT_TRUE(reused.light().empty());
}

}  // namespace
}  // namespace dpl
