// SPDX-License-Identifier: Apache-2.0
// Trousers whose legs touch in the still pose, and a skirt as wide: one hull for both, told apart by what moving pictures show.
#include "reconstruction/subject/garments/parted_legs.h"

#include <gtest/gtest.h>

#include "modelled_person.h"
#include "reconstruction/subject/garments/clothed_mesh.h"
#include "reconstruction/subject/garments/leg_gap.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr float kTrouserHemY = 0.45f, kLegRadiusM = 0.103f;  // legs 20 cm apart, so they touch

float trouserLeg(const Vec3f& p, float side) {
    return capsule(p, {0.1f * side, 0.1f, 0}, {0.09f * side, 0.9f, 0}, kLegRadiusM);
}

/** All that hides the legs: trousers, or a skirt, which is one tube also where the legs part. */
ModelledPerson person(bool skirt, const Pose& pose, float hemY = kTrouserHemY) {
    ModelledPerson out;
    const auto leg = [](const Vec3f& p) { return uint16_t(p.y > 0.85f ? 0 : p.x > 0 ? 1 : 2); };
    out.add(
        {body().restPositions, body().triangles}, [](const Vec3f&) { return kSkin; }, leg);
    out.add(topSurface(), [](const Vec3f& p) { return p.y > 0.93f && p.y < 1.33f ? kTop : uint8_t(0); });
    const auto label = [&](const Vec3f& p) { return p.y > hemY && p.y < 0.95f ? kBottom : uint8_t(0); };
    if (skirt) {
        std::vector<Mat3x4f> world;
        jointTransforms(joints(), pose, world);
        // Hangs over both posed legs and the straight line between them.
        const Vec3f l = world[1] * Vec4f(0.1f, 0.1f, 0, 1), r = world[2] * Vec4f(-0.1f, 0.1f, 0, 1);
        out.add(meshOf(
                    [&](const Vec3f& p) {
                        float nearest = 1;
                        for (int i = 0; i <= 8; ++i) {
                            const float t = float(i) / 8;
                            nearest = std::min(nearest, capsule(p, glm::mix(l, r, t), {0.09f - 0.18f * t, 0.9f, 0}, kLegRadiusM));
                        }
                        return nearest;
                    },
                    0.018f),
                label);
    } else {
        for (const float side : {1.0f, -1.0f})
            out.add(meshOf([&](const Vec3f& p) { return trouserLeg(p, side); }, 0.018f), label,
                    [&](const Vec3f&) { return side > 0 ? 1 : 2; });
    }
    return out;
}

Pose stride(float degrees) {
    Pose pose = Pose::rest(3);
    pose.localRotations[1] = glm::angleAxis(glm::radians(degrees), Vec3f(0, 0, 1));
    pose.localRotations[2] = glm::angleAxis(glm::radians(-degrees), Vec3f(0, 0, 1));
    return pose;
}

Result<GarmentFit> dressed(bool skirt, float strideDegrees, float movingHemY = kTrouserHemY) {
    const std::vector<GarmentView> still = stillPictures(person(skirt, Pose::rest(3)), 24);
    std::vector<GarmentView> moving;
    for (int i = 0; i < 8 && strideDegrees > 0; ++i)
        moving.push_back(picture(person(skirt, stride(strideDegrees), movingHemY), stride(strideDegrees), i, 8));
    const std::vector<ScanLabel> labels = {{"background", 0}, {"body", kSkin}, {"top", kTop}, {"bottom", kBottom}};
    const std::vector<Vec3f> offsets(body().restPositions.size(), Vec3f(0));
    Jobs jobs(2);
    const auto rig = joints();
    return makeClothedMesh({body(), rig, offsets, still, moving, labels}, jobs);
}

/** Triangles of the bottom that join the legs, well below the crotch, and the longest stretch of an edge there in a stride. */
struct Joined {
    size_t triangles = 0;
    float stretch = 1;
};

Joined joinedLegs(const MeshData& mesh) {
    Joined out;
    const LayerData& layer = mesh.layers[2];
    std::vector<Mat3x4f> world;
    jointTransforms(joints(), stride(20), world);
    const auto posed = [&](uint32_t v) {
        return skinVertex(mesh.restPositions[v], mesh.jointIndices[v], mesh.jointWeights[v], world.data());
    };
    for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t) {
        float low = 1, high = -1;
        for (int c = 0; c < 3; ++c) {
            const uint32_t a = mesh.triangles[t][c], b = mesh.triangles[t][(c + 1) % 3];
            if (mesh.restPositions[a].y > 0.72f) low = high = NAN;
            low = std::min(low, mesh.restPositions[a].x), high = std::max(high, mesh.restPositions[a].x);
            out.stretch =
                std::max(out.stretch, glm::length(posed(a) - posed(b)) / glm::length(mesh.restPositions[a] - mesh.restPositions[b]));
        }
        out.triangles += low < -0.003f && high > 0.003f;
    }
    return out;
}

TEST(LegGap, isTheAirHalfwayBetweenTheLegs) {
    const LegGap gap(body(), joints(), body().restPositions);
    ASSERT_FALSE(gap.empty());
    EXPECT_NEAR(gap({0, 0.5f, 0}), 0.007f, 1e-3f);
    EXPECT_NEAR(gap({0, 0.5f, 0.12f}), 0.007f, 1e-3f);  // in front of the legs too
    EXPECT_LT(gap({0.015f, 0.5f, 0}), 0);
    EXPECT_LT(gap({0.1f, 0.5f, 0}), 0);
    EXPECT_LT(gap({0, 0.85f, 0}), 0);  // above the crotch
    EXPECT_LT(gap({0.5f, 0.5f, 0}), 0);
}

TEST(LegGap, isEmptyWithoutNamedLegs) {
    auto rig = joints();
    rig[1].humanoidBone = "";
    const LegGap gap(body(), rig, body().restPositions);
    EXPECT_TRUE(gap.empty());
    EXPECT_LT(gap({0, 0.5f, 0}), 0);
}

TEST(LegGap, bringsTheWallsTogether) {
    const LegGap gap(body(), joints(), body().restPositions);
    SurfaceMesh walls{{{0.007f, 0.5f, 0}, {-0.007f, 0.5f, 0}, {0.007f, 0.5f, 0.05f}, {0.1f, 0.5f, 0}, {0.007f, 0.9f, 0}}, {}};
    const SurfaceMesh before = walls;
    gap.close(walls, [](const Vec3f&) { return false; });
    EXPECT_EQ(walls.positions, before.positions);
    gap.close(walls, [](const Vec3f&) { return true; });
    EXPECT_NEAR(walls.positions[0].x, 0.001f, 2e-4f);
    EXPECT_NEAR(walls.positions[1].x, -0.001f, 2e-4f);
    EXPECT_NEAR(walls.positions[2].x, 0.001f, 1e-3f);
    EXPECT_EQ(walls.positions[3], before.positions[3]);
    EXPECT_EQ(walls.positions[4], before.positions[4]);
}

TEST(PartedLegs, trousersThatTouchGetTwoLegs) {
    const auto fit = dressed(false, 20);
    ASSERT_TRUE(fit) << fit.error().message;
    ASSERT_EQ(fit->legs.size(), 1u);
    EXPECT_EQ(fit->legs[0].name, "bottom");
    EXPECT_TRUE(fit->legs[0].seen.parted()) << fit->legs[0].seen.free << " free, " << fit->legs[0].seen.cloth << " cloth";
    EXPECT_NE(fit->summary.find("bottom has two legs"), std::string::npos) << fit->summary;
    const Joined joined = joinedLegs(fit->clothed.mesh);
    EXPECT_EQ(joined.triangles, 0u);
    EXPECT_LT(joined.stretch, 2.0f);
    EXPECT_LE(fit->largestWeightStep, 0.12f);
    // The two legs nearly touch, as in the pictures.
    float left = 1, right = -1;
    const SurfaceMesh bottom = layerOf(fit->clothed.mesh, 2);
    for (const Vec3f& p : bottom.positions)
        if (p.y < 0.68f && p.y > 0.55f) (p.x > 0 ? left = std::min(left, p.x) : right = std::max(right, p.x));
    EXPECT_LT(left - right, 0.006f);
}

TEST(PartedLegs, aSkirtStaysOneTube) {
    const auto fit = dressed(true, 20);
    ASSERT_TRUE(fit) << fit.error().message;
    ASSERT_EQ(fit->legs.size(), 1u);
    EXPECT_FALSE(fit->legs[0].seen.parted()) << fit->legs[0].seen.free << " free, " << fit->legs[0].seen.cloth << " cloth";
    EXPECT_GT(fit->legs[0].seen.cloth, 100u);
    EXPECT_GT(joinedLegs(fit->clothed.mesh).triangles, 10u);
}

TEST(PartedLegs, aSkirtWhoseHemSwungUpStaysOneTube) {
    const auto fit = dressed(true, 20, kTrouserHemY + 0.2f);
    ASSERT_TRUE(fit) << fit.error().message;
    ASSERT_EQ(fit->legs.size(), 1u);
    EXPECT_FALSE(fit->legs[0].seen.parted()) << fit->legs[0].seen.free << " free, " << fit->legs[0].seen.cloth << " cloth";
}

TEST(PartedLegs, withoutMovingPicturesClothStaysAsItIsSeen) {
    const auto fit = dressed(false, 0);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_TRUE(fit->legs.empty());
    EXPECT_GT(joinedLegs(fit->clothed.mesh).triangles, 10u);
}

}  // namespace
}  // namespace dpl
