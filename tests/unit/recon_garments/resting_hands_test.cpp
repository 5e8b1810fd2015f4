// SPDX-License-Identifier: Apache-2.0
// A person whose left hand rests on the hip, and one surface around trunk and arm, as the hull makes it.
#include "reconstruction/subject/garments/resting_hands.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "capsule.h"

namespace dpl {
namespace {

struct Bone {
    Vec3f from, to;
    float radius;
};
constexpr Bone kTrunk{{0, 0.9f, 0}, {0, 1.35f, 0}, 0.13f}, kUpperArm{{0.16f, 1.4f, 0}, {0.4f, 1.2f, 0}, 0.045f},
    kForearm{{0.4f, 1.2f, 0}, {0.17f, 1.0f, 0}, 0.035f};
constexpr uint16_t kOnTrunk = 0, kOnUpperArm = 1, kOnForearm = 2;

float limb(const Vec3f& p, const Bone& bone, float moreM = 0) {
    return capsule(p, bone.from, bone.to, bone.radius + moreM);
}

SurfaceMesh meshOf(const ScalarField& field) {
    SampleGrid grid;
    appendSamples(grid.xs, -0.3f, 0.55f, 0.012f);
    appendSamples(grid.ys, 0.65f, 1.6f, 0.012f);
    appendSamples(grid.zs, -0.3f, 0.3f, 0.012f);
    Jobs jobs(2);
    return largestPiece(marchField(field, grid, jobs));
}

struct Person {
    std::vector<JointData> joints{
        {"hips", -1, kTrunk.from, "hips"}, {"upper", 0, kUpperArm.from, "leftUpperArm"}, {"lower", 1, kForearm.from, "leftLowerArm"}};
    MeshData body;
    Person() {
        uint16_t joint = 0;
        for (const Bone& bone : {kTrunk, kUpperArm, kForearm}) {
            const SurfaceMesh skin = meshOf([&](const Vec3f& p) { return limb(p, bone); });
            const auto first = uint32_t(body.restPositions.size());
            body.restPositions.insert(body.restPositions.end(), skin.positions.begin(), skin.positions.end());
            body.jointIndices.resize(body.restPositions.size(), {joint, 0, 0, 0});
            body.jointWeights.resize(body.restPositions.size(), {255, 0, 0, 0});
            for (const Triangle& t : skin.triangles) body.triangles.push_back(t + first);
            ++joint;
        }
    }
    std::vector<SurfacePoint> below(const SurfaceMesh& piece) const { return wornBodyBelow(piece, body, joints, body.restPositions); }
    WornPiece apart(const SurfaceMesh& piece) const { return withArmsApart(piece, body, joints, body.restPositions); }
    /** Triangles with corners on both joints. */
    size_t joins(const WornPiece& piece, uint16_t a, uint16_t b) const {
        size_t count = 0;
        for (const Triangle& t : piece.mesh.triangles) {
            std::array<uint16_t, 3> on{};
            for (int c = 0; c < 3; ++c) on[size_t(c)] = body.jointIndices[body.triangles[piece.below[t[c]].triangle].x].x;
            count += std::find(on.begin(), on.end(), a) != on.end() && std::find(on.begin(), on.end(), b) != on.end();
        }
        return count;
    }
};

TEST(RestingHands, aSleeveIsNotJoinedToTheHipThatItTouches) {
    const Person person;
    const SurfaceMesh jacket = meshOf([](const Vec3f& p) {
        return std::min({limb(p, kTrunk, 0.02f), limb(p, kUpperArm, 0.02f), limb(p, kForearm, 0.02f)});
    });
    const WornPiece joined{jacket, person.below(jacket)}, apart = person.apart(jacket);
    ASSERT_GT(person.joins(joined, kOnTrunk, kOnForearm), 20u) << "the case must be hard";
    EXPECT_EQ(person.joins(apart, kOnTrunk, kOnForearm), 0u);
    EXPECT_EQ(person.joins(apart, kOnUpperArm, kOnForearm), person.joins(joined, kOnUpperArm, kOnForearm)) << "over the elbow";
    EXPECT_GE(person.joins(apart, kOnTrunk, kOnUpperArm), person.joins(joined, kOnTrunk, kOnUpperArm)) << "over the shoulder";

    // In this pose the cloth is where it was, without a gap.
    ASSERT_EQ(apart.mesh.triangles.size(), jacket.triangles.size());
    for (size_t t = 0; t < jacket.triangles.size(); ++t)
        for (int c = 0; c < 3; ++c) ASSERT_EQ(apart.mesh.positions[apart.mesh.triangles[t][c]], jacket.positions[jacket.triangles[t][c]]);
    EXPECT_GT(apart.mesh.positions.size(), jacket.positions.size());
    EXPECT_EQ(apart.below.size(), apart.mesh.positions.size());
}

TEST(RestingHands, aCapeOverArmAndTrunkStaysWhole) {
    const Person person;
    const SurfaceMesh slab = meshOf([](const Vec3f& p) {  // before both
        return std::max({std::abs(p.z - 0.15f) - 0.03f, std::abs(p.x - 0.15f) - 0.35f, std::abs(p.y - 1.15f) - 0.3f});
    });
    SurfaceMesh cape{slab.positions, {}};  // its front
    for (const Triangle& t : slab.triangles)
        if (std::min({slab.positions[t.x].z, slab.positions[t.y].z, slab.positions[t.z].z}) > 0.17f) cape.triangles.push_back(t);
    cape = withoutUnused(cape);
    ASSERT_GT(person.joins({cape, person.below(cape)}, kOnTrunk, kOnForearm), 20u) << "the case must be hard";
    EXPECT_EQ(person.apart(cape).mesh.positions.size(), cape.positions.size());
}

TEST(RestingHands, trousersThatAHandTouchesStayWhole) {
    const Person person;
    const SurfaceMesh trousers = meshOf([](const Vec3f& p) { return std::max(limb(p, kTrunk, 0.02f), p.y - 1.05f); });
    EXPECT_EQ(person.apart(trousers).mesh.positions.size(), trousers.positions.size());
}

}  // namespace
}  // namespace dpl
