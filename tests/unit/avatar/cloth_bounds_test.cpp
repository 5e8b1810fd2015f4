// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/cloth_bounds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sdk/avatar/stress_poses.h"

namespace dpl {
namespace {

constexpr uint32_t kRings = 20, kAround = 48;  // edges of about 3 cm

std::vector<JointData> legs() {
    return {{"hips", -1, {0, 1, 0}, "hips"},
            {"thigh_l", 0, {0.1f, 0.95f, 0}, "leftUpperLeg"},
            {"shin_l", 1, {0.1f, 0.5f, 0}, "leftLowerLeg"},
            {"foot_l", 2, {0.1f, 0.08f, 0}, "leftFoot"},
            {"thigh_r", 0, {-0.1f, 0.95f, 0}, "rightUpperLeg"},
            {"shin_r", 4, {-0.1f, 0.5f, 0}, "rightLowerLeg"},
            {"foot_r", 5, {-0.1f, 0.08f, 0}, "rightFoot"}};
}

/** A skirt from the waist to below the knees. share: of the legs' weights at the hem; each half follows its own leg. */
AvatarData skirted(float share) {
    AvatarData a;
    a.joints = legs();
    for (uint32_t r = 0; r <= kRings; ++r)
        for (uint32_t s = 0; s < kAround; ++s) {
            const float down = float(r) / kRings, angle = 6.2831853f * (float(s) + 0.5f) / kAround, radius = 0.15f + 0.1f * down;
            a.mesh.restPositions.emplace_back(radius * std::cos(angle), 1 - 0.6f * down, radius * std::sin(angle));
            const auto leg = uint8_t(255 * share * down);
            a.mesh.jointIndices.emplace_back(0, std::cos(angle) > 0 ? 1 : 4, 0, 0);
            a.mesh.jointWeights.emplace_back(255 - leg, leg, 0, 0);
        }
    for (uint32_t r = 0; r < kRings; ++r)
        for (uint32_t s = 0; s < kAround; ++s) {
            const uint32_t p = r * kAround + s, q = r * kAround + (s + 1) % kAround;
            a.mesh.triangles.push_back({p, q, p + kAround});
            a.mesh.triangles.push_back({q, q + kAround, p + kAround});
        }
    a.mesh.layers = {{"skirt", "garment", 0, uint32_t(a.mesh.restPositions.size()), 0, uint32_t(a.mesh.triangles.size())}};
    return a;
}

double longestEdge(const AvatarData& a, const Pose& pose) {
    Jobs jobs(1);
    std::vector<Mat3x4f> transforms;
    std::vector<Vec3f> posed;
    jointTransforms(a.joints, pose, transforms);
    skin(a.mesh, transforms, jobs, posed);
    double longest = 0;
    for (const Triangle& t : a.mesh.triangles)
        for (int c = 0; c < 3; ++c) {
            const uint32_t p = t[c], q = t[(c + 1) % 3];
            longest = std::max(longest,
                               double(glm::length(posed[p] - posed[q]) / glm::length(a.mesh.restPositions[p] - a.mesh.restPositions[q])));
        }
    return longest;
}

TEST(ClothBounds, aSkirtThatTearsBetweenTheLegsIsEvened) {
    AvatarData a = skirted(1);
    const AvatarData before = a;
    const std::vector<Pose> poses = stressPoses(a.joints);
    ASSERT_EQ(poses.size(), 9u);
    double torn = 0, longest = 0;
    for (const Pose& pose : poses) torn = std::max(torn, longestEdge(a, pose));
    EXPECT_GT(torn, 6) << "each half of the hem follows its own leg";
    const ClothBounds bounds = boundGarments(a.joints, a.mesh);
    for (const Pose& pose : poses) longest = std::max(longest, longestEdge(a, pose));
    EXPECT_NEAR(bounds.longestBefore, torn, 1e-3);
    EXPECT_NEAR(bounds.longestAfter, longest, 1e-3);
    EXPECT_LE(longest, kTornClothStretch);
    EXPECT_LT(longestEdge(a, poses[2]), kMostClothStretch) << "a small step";
    EXPECT_GT(bounds.evened, 100u);
    for (uint32_t v = 0; v < a.mesh.restPositions.size(); ++v) {
        const glm::u8vec4 w = a.mesh.jointWeights[v];
        ASSERT_EQ(w.x + w.y + w.z + w.w, 255);
    }
    for (uint32_t v = 0; v < kAround; ++v) EXPECT_GT(a.mesh.jointWeights[v].x, 230) << "the waist keeps to the hips";
    EXPECT_EQ(a.mesh.restPositions, before.mesh.restPositions);
    // A second time nothing is left to do, and the same input gives the same weights.
    AvatarData again = before;
    boundGarments(again.joints, again.mesh);
    EXPECT_EQ(again.mesh.jointWeights, a.mesh.jointWeights);
    EXPECT_EQ(boundGarments(again.joints, again.mesh).evened, 0u);
    EXPECT_EQ(again.mesh.jointWeights, a.mesh.jointWeights);
}

TEST(ClothBounds, aSkirtThatIsMadeHoldsInLungesAndKicksTooAndReadersLeaveItAlone) {
    AvatarData read = skirted(0.5f), made = read;
    const auto longestIn = [&](const AvatarData& a) {
        double longest = 0;
        for (const Pose& pose : clothPoses(a.joints)) longest = std::max(longest, longestEdge(a, pose));
        return longest;
    };
    ASSERT_EQ(clothPoses(made.joints).size(), 16u);
    boundGarments(read.joints, read.mesh);
    EXPECT_GT(longestIn(read), kTornClothStretch) << "a reader looks at nine poses only";
    const ClothBounds bounds = boundNewGarments(made.joints, made.mesh);
    EXPECT_NEAR(bounds.longestAfter, longestIn(made), 1e-3);
    EXPECT_LT(bounds.longestAfter, 1.1 * kMostClothStretch) << "what rounding to 1/255 leaves";
    EXPECT_EQ(boundGarments(made.joints, made.mesh).evened, 0u);
    for (const glm::u8vec4& w : made.mesh.jointWeights) ASSERT_EQ(w.x + w.y + w.z + w.w, 255);
}

TEST(ClothBounds, clothThatHoldsKeepsItsWeights) {
    AvatarData a = skirted(0.03f);
    const AvatarData before = a;
    const ClothBounds bounds = boundGarments(a.joints, a.mesh);
    EXPECT_LT(bounds.longestBefore, kTornClothStretch);
    EXPECT_EQ(bounds.evened, 0u);
    EXPECT_EQ(a.mesh.jointIndices, before.mesh.jointIndices);
    EXPECT_EQ(a.mesh.jointWeights, before.mesh.jointWeights);
}

TEST(ClothBounds, onlyGarmentsOfPeopleAreTouched) {
    AvatarData body = skirted(1), animal = skirted(1), broken = skirted(1);
    body.mesh.layers[0].role = "body";
    for (JointData& joint : animal.joints) joint.name = "x", joint.humanoidBone.clear();
    broken.joints[2].parent = 5;
    for (AvatarData* a : {&body, &animal, &broken}) EXPECT_EQ(boundGarments(a->joints, a->mesh).evened, 0u);
}

TEST(ClothBounds, degenerateClothIsSurvived) {
    AvatarData a = skirted(1);
    a.mesh.restPositions[700] = a.mesh.restPositions[701];
    a.mesh.restPositions[720] = Vec3f(NAN);
    a.mesh.triangles[5] = {7, 7, 7};
    boundGarments(a.joints, a.mesh), boundNewGarments(a.joints, a.mesh);
    for (const glm::u8vec4& w : a.mesh.jointWeights) ASSERT_EQ(w.x + w.y + w.z + w.w, 255);
    a.mesh.triangles.clear(), a.mesh.layers[0].triangleCount = 0;
    EXPECT_EQ(boundGarments(a.joints, a.mesh).evened, 0u);
}

}  // namespace
}  // namespace dpl
