// SPDX-License-Identifier: Apache-2.0
// The properties of the built-in body that builtin_body.h states.
#include "reconstruction/subject/sample/builtin_body.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <set>

#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/sample/skinning.h"

namespace dpl {
namespace {

const BodyModel& body() {
    static const BodyModel kBody = makeBuiltinBody();
    return kBody;
}

double volume(const std::vector<Vec3d>& p, const std::vector<Triangle>& triangles) {
    double sum = 0;
    for (const Triangle& t : triangles) sum += glm::dot(p[t.x], glm::cross(p[t.y], p[t.z])) / 6;
    return sum;
}

std::vector<Vec3d> posed(const TruthPose& pose) {
    const MeshData& mesh = body().mesh;
    const auto g = truthTransforms(body().joints, pose);
    std::vector<Vec3d> out;
    for (size_t v = 0; v < mesh.restPositions.size(); ++v)
        out.push_back(skinned(g, mesh.jointIndices[v], mesh.jointWeights[v], Vec3d(mesh.restPositions[v])));
    return out;
}

TruthPose restPose() {
    return {std::vector<Vec3d>(body().joints.size(), Vec3d(0)), Vec3d(0)};
}

TEST(BuiltinBody, meshIsAClosedManifoldInOnePiece) {
    const MeshData& mesh = body().mesh;
    EXPECT_GE(mesh.restPositions.size(), 10000u);
    EXPECT_LE(mesh.restPositions.size(), 16000u);
    std::map<std::pair<uint32_t, uint32_t>, int> directed;
    for (const Triangle& t : mesh.triangles)
        for (int c = 0; c < 3; ++c) ++directed[{t[c], t[(c + 1) % 3]}];
    for (const auto& [edge, count] : directed) {
        ASSERT_EQ(count, 1) << "edge used twice in one direction";
        ASSERT_TRUE(directed.contains({edge.second, edge.first})) << "open edge";
    }
    // Genus 0: V − E + F = 2.
    EXPECT_EQ(int64_t(mesh.restPositions.size()) - int64_t(directed.size() / 2) + int64_t(mesh.triangles.size()), 2);
}

TEST(BuiltinBody, noTriangleIsDegenerateOrNearlySo) {
    const MeshData& mesh = body().mesh;
    size_t slender = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a(mesh.restPositions[t.x]), b(mesh.restPositions[t.y]), c(mesh.restPositions[t.z]);
        const double doubleArea = glm::length(glm::cross(b - a, c - a));
        const double longest2 = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
        ASSERT_GT(doubleArea, 2e-7) << "a triangle below 0.1 mm²";  // the shortest wanted edge is 3.6 mm, which gives 6 mm²
        ASSERT_LT(longest2, 20 * doubleArea);
        slender += longest2 > 4 * doubleArea;  // 1.15 for an equilateral triangle
    }
    EXPECT_LT(slender, mesh.triangles.size() / 200);
}

TEST(BuiltinBody, standsOnTheFloorFacingForward) {
    Vec3f low(1e3f), high(-1e3f);
    for (const Vec3f& p : body().mesh.restPositions) low = glm::min(low, p), high = glm::max(high, p);
    EXPECT_NEAR(low.y, 0, 0.005);  // the sole is rounded over a few millimetres
    EXPECT_NEAR(high.y, 1.75, 0.01);
    EXPECT_NEAR(low.x + high.x, 0, 0.004);  // symmetric to about an edge length
    for (const BodyKeypoint& k : body().keypoints)
        if (k.name == "nose") {
            EXPECT_GT(body().mesh.restPositions[k.vertices[0].first].z, 0.10f);
        }
    EXPECT_GT(volume(posed(restPose()), body().mesh.triangles), 0.05);  // positive: triangles face outward; at least 50 litres
}

TEST(BuiltinBody, skeletonHas55JointsWithHumanoidNames) {
    const auto& joints = body().joints;
    ASSERT_EQ(joints.size(), 55u);
    std::set<std::string> bones;
    for (size_t j = 0; j < joints.size(); ++j) {
        EXPECT_LT(joints[j].parent, int(j));
        EXPECT_TRUE(bones.insert(joints[j].humanoidBone).second) << joints[j].name;
    }
    for (const char* bone : {"hips", "leftUpperArm", "rightFoot", "leftLittleDistal", "rightThumbMetacarpal", "head"})
        EXPECT_TRUE(bones.contains(bone));
    for (uint8_t j = 0; j < 55; ++j) {
        const Vec3f a = joints[j].restPosition, b = joints[mirroredJoint(j)].restPosition;
        EXPECT_LT(glm::length(a - Vec3f(-b.x, b.y, b.z)), 1e-6f) << joints[j].name;
    }
}

TEST(BuiltinBody, weightsSumTo255AndFingersNeverMix) {
    const MeshData& mesh = body().mesh;
    for (size_t v = 0; v < mesh.restPositions.size(); ++v) {
        int sum = 0;
        std::set<int> fingers;
        bool left = false, right = false;
        for (int k = 0; k < 4; ++k) {
            sum += mesh.jointWeights[v][k];
            const int j = mesh.jointIndices[v][k];
            // Skin between two knuckles may follow the first bones of both fingers. Further out it must follow one finger only.
            if (mesh.jointWeights[v][k] > 0 && j >= kLeftIndex1 && (j - kLeftIndex1) % 3 > 0) fingers.insert((j - kLeftIndex1) / 3);
            if (mesh.jointWeights[v][k] > 20) left |= j == kLeftKnee || j == kLeftAnkle, right |= j == kRightKnee || j == kRightAnkle;
        }
        ASSERT_EQ(sum, 255);
        ASSERT_LE(fingers.size(), 1u) << "vertex " << v;
        ASSERT_FALSE(left && right);
    }
}

TEST(BuiltinBody, volumeHoldsWhenJointsBend) {
    const double rest = volume(posed(restPose()), body().mesh.triangles);
    TruthPose pose = restPose();
    pose.rotations[kLeftElbow] = {0, -1.5708, 0};
    pose.rotations[kRightElbow] = {0, 1.5708, 0};
    EXPECT_NEAR(volume(posed(pose), body().mesh.triangles) / rest, 1, 0.15);
    pose.rotations[kLeftKnee] = {1.5708, 0, 0};
    pose.rotations[kLeftHip] = {-1.2, 0, 0};
    EXPECT_NEAR(volume(posed(pose), body().mesh.triangles) / rest, 1, 0.15);
}

TEST(BuiltinBody, morphsMoveSkinAndJointsTogether) {
    std::map<std::string, const ShapeMorph*> byName;
    for (const ShapeMorph& m : body().morphs) {
        byName[m.name] = &m;
        ASSERT_EQ(m.vertexOffsets.size(), body().mesh.restPositions.size());
        ASSERT_EQ(m.jointOffsets.size(), body().joints.size());
        float most = 0;
        for (const Vec3f& o : m.vertexOffsets) most = std::max(most, glm::length(o));
        EXPECT_GT(most, 0.002f) << m.name;
        EXPECT_LT(most, 0.08f) << m.name;
    }
    for (const char* name : {"height", "weight", "build", "shoulder_width", "hip_width", "arm_length", "leg_length", "torso_length",
                             "head_size", "hair_volume", "chest"})
        ASSERT_TRUE(byName.contains(name)) << name;
    for (const char* name : {"leg_length", "height", "torso_length"})  // feet stay on the floor
        for (size_t v = 0; v < body().mesh.restPositions.size(); ++v)
            if (body().mesh.restPositions[v].y < 0.02f) {
                ASSERT_LT(std::abs(byName[name]->vertexOffsets[v].y), 0.002f) << name;
            }
    const auto& arms = byName["arm_length"]->jointOffsets;
    EXPECT_GT(arms[kLeftWrist].x, arms[kLeftElbow].x);
    EXPECT_LT(glm::length(arms[kLeftShoulder]), 1e-6f);
}

TEST(BuiltinBody, has24KeypointsAnd40OfTheHandsWithWeightsThatSumToOne) {
    ASSERT_EQ(body().keypoints.size(), 64u);
    for (size_t k = 0; k < handKeypointNames().size(); ++k) EXPECT_EQ(body().keypoints[24 + k].name, handKeypointNames()[k]);
    for (const BodyKeypoint& k : body().keypoints) {
        float sum = 0;
        for (const auto& [index, weight] : k.vertices) sum += weight;
        for (const auto& [index, weight] : k.joints) sum += weight;
        EXPECT_NEAR(sum, 1, 1e-5) << k.name;
    }
}

TEST(BuiltinBody, sameBytesOnOneTwoAndThreeThreads) {
    Jobs one(1), three(3);
    const BodyModel a = makeBuiltinBody(one), b = makeBuiltinBody(three);
    for (const BodyModel* other : {&a, &b}) {
        ASSERT_EQ(other->mesh.restPositions, body().mesh.restPositions);
        ASSERT_EQ(other->mesh.triangles, body().mesh.triangles);
        ASSERT_EQ(other->mesh.jointWeights, body().mesh.jointWeights);
        ASSERT_EQ(other->mesh.jointIndices, body().mesh.jointIndices);
        for (size_t m = 0; m < body().morphs.size(); ++m) ASSERT_EQ(other->morphs[m].vertexOffsets, body().morphs[m].vertexOffsets);
    }
}

}  // namespace
}  // namespace dpl
