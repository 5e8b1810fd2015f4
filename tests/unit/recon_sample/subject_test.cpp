// SPDX-License-Identifier: Apache-2.0
// The clothed subject: clothes lie outside the body, static frames are plain skinning, cloth slides and depends on earlier motion.
#include "reconstruction/subject/sample/subject.h"

#include <gtest/gtest.h>

#include <map>

#include "reconstruction/subject/sample/skeleton.h"
#include "tests/unit/recon_sample/subjects.h"

namespace dpl {
namespace {

TruthPose restPose() {
    return {std::vector<Vec3d>(subject().joints.size(), Vec3d(0)), Vec3d(0)};
}

TEST(Subject, wearsFiveLayersThatShareNoVertices) {
    const MeshData& mesh = subject().mesh;
    ASSERT_EQ(subject().parts.size(), 5u);
    uint32_t vertex = 0, triangle = 0;
    for (size_t i = 0; i < mesh.layers.size(); ++i) {
        const LayerData& layer = mesh.layers[i];
        EXPECT_EQ(layer.firstVertex, vertex);
        EXPECT_EQ(layer.firstTriangle, triangle);
        EXPECT_EQ(layer.name, subject().parts[i].name);
        EXPECT_GT(layer.vertexCount, 500u) << layer.name;
        for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t)
            for (int c = 0; c < 3; ++c) {
                ASSERT_GE(mesh.triangles[t][c], layer.firstVertex);
                ASSERT_LT(mesh.triangles[t][c], layer.firstVertex + layer.vertexCount);
            }
        vertex += layer.vertexCount, triangle += layer.triangleCount;
    }
    EXPECT_EQ(vertex, mesh.restPositions.size());
    EXPECT_EQ(triangle, mesh.triangles.size());
    for (const auto& w : mesh.jointWeights) ASSERT_EQ(int(w[0]) + w[1] + w[2] + w[3], 255);
}

TEST(Subject, clothesAreOpenManifoldSheetsWithWholeHems) {
    const MeshData& mesh = subject().mesh;
    const std::map<std::string, size_t> holes{
        {"hair", 1}, {"shoes", 2}, {"top", 4}, {"bottom", 3}};  // openings: of the top its neck, two cuffs and hem
    for (const auto& [name, expected] : holes) {
        const auto layer = *std::find_if(mesh.layers.begin(), mesh.layers.end(), [&](const LayerData& l) { return l.name == name; });
        EXPECT_EQ(openings(mesh, layer).size(), expected) << name;
    }
}

TEST(Subject, clothesStayOutsideTheBodyAtRest) {
    const Subject& s = subject();
    const LayerData& body = s.mesh.layers[0];
    std::vector<Vec3f> normal(body.vertexCount, Vec3f(0));
    for (uint32_t t = 0; t < body.triangleCount; ++t) {
        const Triangle& f = s.mesh.triangles[t];
        const Vec3f n =
            glm::cross(s.mesh.restPositions[f.y] - s.mesh.restPositions[f.x], s.mesh.restPositions[f.z] - s.mesh.restPositions[f.x]);
        normal[f.x] += n, normal[f.y] += n, normal[f.z] += n;
    }
    for (size_t i = 1; i < s.parts.size(); ++i) {
        if (s.parts[i].label == kLabelHair) continue;  // hair lies on the skull and moves rigidly with it
        size_t deep = 0;
        for (uint32_t v = s.mesh.layers[i].firstVertex; v < s.mesh.layers[i].firstVertex + s.mesh.layers[i].vertexCount; ++v) {
            uint32_t best = 0;
            float nearest = 1e9f;
            for (uint32_t b = 0; b < body.vertexCount; ++b) {
                const Vec3f d = s.mesh.restPositions[b] - s.mesh.restPositions[v];
                if (glm::dot(d, d) < nearest) nearest = glm::dot(d, d), best = b;
            }
            // Depth below the tangent plane of the nearest skin vertex. In hollows the plane is off by the sagitta of an edge, 1 mm.
            deep += glm::dot(s.mesh.restPositions[v] - s.mesh.restPositions[best], glm::normalize(normal[best])) < -0.001f;
        }
        EXPECT_EQ(deep, 0u) << s.parts[i].name;
    }
}

TEST(Subject, staticFramesAreExactlySkinning) {
    const Subject& s = subject();
    const TruthPose pose = staticPose(7, 3);
    const auto g = truthTransforms(s.joints, pose);
    const auto at = poseSubject(s, pose, nullptr);
    for (size_t v = 0; v < at.size(); ++v)
        ASSERT_LT(glm::length(at[v] - skinned(g, s.mesh.jointIndices[v], s.mesh.jointWeights[v], Vec3d(s.mesh.restPositions[v]))), 1e-12);
    EXPECT_GT(glm::length(at[0] - Vec3d(s.mesh.restPositions[0])), 1e-5);  // the pose is not the rest pose
}

TEST(Subject, shirtSlidesUpWhenArmsRise) {
    const Subject& s = subject();
    const std::vector<Vec3d> still(s.drivers.size(), Vec3d(0));
    TruthPose pose = restPose();
    pose.rotations[kLeftShoulder] = {0, 0, 1.5};
    pose.rotations[kRightShoulder] = {0, 0, -1.5};
    const auto skin = poseSubject(s, pose, nullptr), cloth = poseSubject(s, pose, &still);
    double most = 0, bodyMost = 0;
    for (size_t v = 0; v < skin.size(); ++v) {
        double& which = v < s.mesh.layers[0].vertexCount ? bodyMost : most;
        which = std::max(which, glm::length(cloth[v] - skin[v]));
    }
    EXPECT_GT(most, 0.01);
    EXPECT_LT(most, 0.08);
    EXPECT_EQ(bodyMost, 0);
}

TEST(Subject, clothDependsOnEarlierMotion) {
    const Subject& s = subject();
    const SampleMotion motion = SampleMotion::dynamicSequence(7, 18.75);
    SwingSimulation swing(s, motion);
    double most = 0;
    for (double t = 0.5; t < 18; t += 0.5)
        for (const Vec3d& lag : swing.at(t)) most = std::max(most, glm::length(lag));
    EXPECT_GT(most, 0.005);   // less than 5 mm would not be visible
    EXPECT_LT(most, 0.0451);  // the limit stated in the header

    // The same pose after motion and at rest: the skin is equal, cloth is not.
    const TruthPose pose = motion.pose(12.7);
    SwingSimulation moving(s, motion);
    const std::vector<Vec3d> lag = moving.at(12.7), still(s.drivers.size(), Vec3d(0));
    const auto a = poseSubject(s, pose, &lag), b = poseSubject(s, pose, &still);
    double cloth = 0;
    for (size_t v = 0; v < a.size(); ++v) {
        const double d = glm::length(a[v] - b[v]);
        if (v < s.mesh.layers[0].vertexCount) {
            ASSERT_EQ(d, 0);
        }
        cloth = std::max(cloth, d);
    }
    EXPECT_GT(cloth, 0.002);
}

TEST(Subject, swingDoesNotDependOnHowOftenItIsAsked) {
    const Subject& s = subject();
    const SampleMotion motion = SampleMotion::dynamicSequence(7, 18.75);
    SwingSimulation once(s, motion), often(s, motion);
    for (double t = 0.1; t < 5; t += 0.1) often.at(t);
    EXPECT_EQ(once.at(5.0), often.at(5.0));
}

TEST(Subject, printIsCrisp) {
    // Along a line through the letters, ink must change between none and full within 1 mm several times.
    int crossings = 0;
    for (float x = -0.12f; x < 0.12f; x += 0.0005f) {
        const float a = logoInk({x, 0.022f}, 0.0003f).x, b = logoInk({x + 0.001f, 0.022f}, 0.0003f).x;
        crossings += std::abs(a - b) > 0.95f;
    }
    EXPECT_GE(crossings, 12);
}

TEST(Subject, seedsMakeDifferentPeopleAndTheSameSeedTheSame) {
    Jobs jobs(3);
    const Subject again = makeSubject(6, jobs);
    EXPECT_EQ(again.mesh.restPositions, subject().mesh.restPositions);
    EXPECT_EQ(again.mesh.triangles, subject().mesh.triangles);
    EXPECT_EQ(again.mesh.jointWeights, subject().mesh.jointWeights);
    const Look a = makeLook(7), b = makeLook(8);
    EXPECT_NE(a.skin, b.skin);
}

}  // namespace
}  // namespace dpl
