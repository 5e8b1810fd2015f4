// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/cloth_weights.h"

#include <cmath>

#include <gtest/gtest.h>

#include "reconstruction/subject/garments/resting_hands.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "sdk/avatar/rig.h"
#include "sdk/math/skinning.h"
#include "tests/unit/must.h"

namespace dpl {
namespace {

TEST(ClothWeights, aVertexWhoseJointsCancelMovesWithItsNeighbours) {
    // A strip on joint 0, whose middle vertex is half on joint 1, turned by 180° against joint 0: the blend has rank one.
    SurfaceMesh strip;
    for (int i = 0; i < 7; ++i) strip.positions.push_back({0.1f * float(i / 2), 0.1f * float(i % 2), 0});
    for (uint32_t i = 0; i + 2 < 7; ++i) strip.triangles.push_back(i % 2 ? Triangle(i + 1, i, i + 2) : Triangle(i, i + 1, i + 2));
    ClothWeights weights;
    weights.joints.assign(7, {0, 1, 0, 0});
    weights.weights.assign(7, {255, 0, 0, 0});
    weights.weights[3] = {128, 127, 0, 0};
    const Mat3x4f shifted(Vec3f(1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, 0, 1), Vec3f(0.5f, 0, 0));
    const Mat3x4f turned(Vec3f(-1, 0, 0), Vec3f(0, -1, 0), Vec3f(0, 0, 1), Vec3f(0));
    const std::vector<Mat3x4f> worldFromRest{shifted, turned};
    const std::vector<Vec3f> rest = unposed(strip, weights, worldFromRest);
    for (size_t v = 0; v < 7; ++v) {
        EXPECT_NEAR(rest[v].x, strip.positions[v].x - 0.5f, 1e-5);
        EXPECT_NEAR(rest[v].y, strip.positions[v].y, 1e-5);
    }
}

Result<ClothWeights> weightsOf(const SurfaceMesh& piece, const MeshData& body, std::span<const JointData> joints,
                               std::span<const Mat3x4f> worldFromRest, Jobs& jobs) {
    std::vector<Vec3f> posed;
    skin(body, worldFromRest, jobs, posed);
    return clothWeights(piece, wornBodyBelow(piece, body, joints, posed), body, joints, worldFromRest, jobs);
}

/** A tube around the y axis, from `bottom` to `top`, open at both ends. */
SurfaceMesh tube(const Vec3f& middle, float radius, float bottom, float top) {
    constexpr uint32_t kAround = 32, kRings = 25;
    SurfaceMesh mesh;
    for (uint32_t ring = 0; ring < kRings; ++ring)
        for (uint32_t i = 0; i < kAround; ++i) {
            const float angle = 6.2831853f * float(i) / kAround, y = bottom + (top - bottom) * float(ring) / (kRings - 1);
            mesh.positions.push_back(middle + Vec3f(radius * std::sin(angle), y, radius * std::cos(angle)));
        }
    for (uint32_t ring = 0; ring + 1 < kRings; ++ring)
        for (uint32_t i = 0; i < kAround; ++i) {
            const uint32_t a = ring * kAround + i, b = ring * kAround + (i + 1) % kAround;
            mesh.triangles.push_back({a, b, b + kAround}), mesh.triangles.push_back({a, b + kAround, a + kAround});
        }
    return mesh;
}

JointData joint(const char* bone, int32_t parent, const Vec3f& at) {
    JointData made;
    made.name = made.humanoidBone = bone;
    made.parent = parent, made.restPosition = at;
    return made;
}

/** Adds a limb as a tube that one joint moves. */
void addLimb(MeshData& body, uint16_t joint, const Vec3f& middle, float radius, float bottom, float top) {
    const SurfaceMesh mesh = tube(middle, radius, bottom, top);
    const auto first = uint32_t(body.restPositions.size());
    for (const Vec3f& p : mesh.positions)
        body.restPositions.push_back(p), body.jointIndices.push_back({joint, 0, 0, 0}), body.jointWeights.push_back({255, 0, 0, 0});
    for (const Triangle& t : mesh.triangles) body.triangles.push_back(t + first);
}

TEST(ClothWeights, aDressOverTheArmsIsOnePieceOfClothWhenTheyMove) {
    // Arms hang inside a wide dress, where no picture sees them, and are nearer to its sides than the trunk is.
    const std::vector<JointData> joints{joint("hips", -1, {0, 0.9f, 0}), joint("leftUpperArm", 0, {0.22f, 1.4f, 0}),
                                        joint("rightUpperArm", 0, {-0.22f, 1.4f, 0})};
    MeshData body;
    addLimb(body, 0, {0, 0, 0}, 0.14f, 0.7f, 1.45f);
    addLimb(body, 1, {0.22f, 0, 0}, 0.04f, 0.85f, 1.4f), addLimb(body, 2, {-0.22f, 0, 0}, 0.04f, 0.85f, 1.4f);
    const SurfaceMesh dress = tube({0, 0, 0}, 0.32f, 0.6f, 1.4f);
    Jobs jobs(2);
    std::vector<Mat3x4f> world;
    jointTransforms(joints, Pose::rest(joints.size()), world);
    const ClothWeights weights = must(weightsOf(dress, body, joints, world, jobs));
    EXPECT_LE(weights.largestStep, 0.13f);
    Pose lifted = Pose::rest(joints.size());
    lifted.localRotations[1] = glm::angleAxis(0.5f, Vec3f(0, 0, 1));
    jointTransforms(joints, lifted, world);
    std::vector<Vec3f> posed;
    for (size_t v = 0; v < dress.positions.size(); ++v)
        posed.push_back(blendedTransform(weights.joints[v], weights.weights[v], world.data()) * Vec4f(dress.positions[v], 1));
    float longest = 0, furthest = 0;
    for (const Triangle& t : dress.triangles)
        for (int c = 0; c < 3; ++c) {
            const uint32_t a = t[c], b = t[(c + 1) % 3];
            longest = std::max(longest, glm::length(posed[a] - posed[b]) / glm::length(dress.positions[a] - dress.positions[b]));
        }
    for (size_t v = 0; v < posed.size(); ++v) furthest = std::max(furthest, glm::length(posed[v] - dress.positions[v]));
    EXPECT_LT(longest, 2.0f) << "torn";
    EXPECT_GT(furthest, 0.05f) << "the arm inside lifts the cloth";
}

TEST(ClothWeights, aSkirtGoesWithAThighThatWouldComeThroughIt) {
    // Two legs as closed-in tubes, each on its joint, and a skirt 5 cm off them. Half way between the legs it hangs free.
    const std::vector<JointData> joints{joint("hips", -1, {0, 0.9f, 0}), joint("leftUpperLeg", 0, {0.1f, 0.9f, 0}),
                                        joint("rightUpperLeg", 0, {-0.1f, 0.9f, 0}), joint("leftLowerLeg", 1, {0.1f, 0.4f, 0}),
                                        joint("rightLowerLeg", 2, {-0.1f, 0.4f, 0})};
    MeshData body;
    addLimb(body, 1, {0.1f, 0, 0}, 0.08f, 0.1f, 0.9f), addLimb(body, 2, {-0.1f, 0, 0}, 0.08f, 0.1f, 0.9f);
    const SurfaceMesh skirt = tube({0, 0, 0}, 0.23f, 0.45f, 0.9f);
    Jobs jobs(2);
    std::vector<Mat3x4f> atRest;
    jointTransforms(joints, Pose::rest(joints.size()), atRest);
    const ClothWeights held = must(weightsOf(skirt, body, joints, atRest, jobs));
    std::vector<JointData> nameless = joints;  // no humanoid bones, so no stress poses
    for (JointData& j : nameless) j.name = j.humanoidBone = "";
    const ClothWeights free = must(weightsOf(skirt, body, nameless, atRest, jobs));

    Pose stride = Pose::rest(joints.size());
    stride.localRotations[1] = glm::angleAxis(-0.6f, Vec3f(1, 0, 0)), stride.localRotations[2] = glm::angleAxis(0.35f, Vec3f(1, 0, 0));
    std::vector<Mat3x4f> striding;
    std::vector<Vec3f> legs;
    jointTransforms(joints, stride, striding);
    skin(body, striding, jobs, legs);
    const ClosestSurface surface(legs, body.triangles);
    const auto inside = [&](const ClothWeights& weights) {
        size_t count = 0;
        for (size_t v = 0; v < skirt.positions.size(); ++v)
            count += surface.signedDistance(
                         blendedTransform(weights.joints[v], weights.weights[v], striding.data()) * Vec4f(skirt.positions[v], 1), 0.1f) < 0;
        return count;
    };
    EXPECT_GT(inside(free), 20u) << "the case must be hard";
    EXPECT_LT(inside(held), inside(free) / 2);
    EXPECT_LE(held.largestStep, 0.13f);
}

/** Trunk and left arm, whose forearm lies against the trunk. */
struct HandOnHip {
    std::vector<JointData> joints{joint("hips", -1, {0, 0.9f, 0}), joint("leftUpperArm", 0, {0.25f, 1.4f, 0}),
                                  joint("leftLowerArm", 1, {0.13f, 1.1f, 0})};
    MeshData body;
    HandOnHip() {
        addLimb(body, 0, {0, 0, 0}, 0.1f, 0.6f, 1.45f);
        addLimb(body, 1, {0.25f, 0, 0}, 0.04f, 1.1f, 1.4f), addLimb(body, 2, {0.13f, 0, 0}, 0.03f, 0.9f, 1.1f);
    }
    /** Largest weight of the forearm in a piece. */
    float onForearm(const SurfaceMesh& piece) const {
        Jobs jobs(2);
        std::vector<Mat3x4f> world;
        jointTransforms(joints, Pose::rest(joints.size()), world);
        const ClothWeights weights = must(weightsOf(piece, body, joints, world, jobs));
        int most = 0;
        for (size_t v = 0; v < piece.positions.size(); ++v)
            for (int k = 0; k < 4; ++k)
                if (weights.joints[v][k] == 2) most = std::max(most, int(weights.weights[v][k]));
        return float(most) / 255;
    }
};

TEST(ClothWeights, trousersDoNotFollowAHandOnTheHip) {
    HandOnHip person;
    const SurfaceMesh trousers = tube({0, 0, 0}, 0.14f, 0.6f, 1.1f);
    EXPECT_EQ(person.onForearm(trousers), 0);
    for (JointData& j : person.joints) j.name = j.humanoidBone = "";  // nobody knows which joint is the forearm
    EXPECT_GT(person.onForearm(trousers), 0.3f) << "the case must be hard";
}

TEST(ClothWeights, sleevesAndGlovesFollowTheForearm) {
    const HandOnHip person;
    const SurfaceMesh glove = tube({0.13f, 0, 0}, 0.035f, 0.92f, 1.08f);
    EXPECT_GT(person.onForearm(glove), 0.9f);
    SurfaceMesh sleeve = tube({0, 0, 0}, 0.05f, 0.9f, 1.4f);  // bends from the upper arm's place to the forearm's
    for (Vec3f& p : sleeve.positions) p.x += p.y > 1.1f ? 0.25f : 0.13f;
    EXPECT_GT(person.onForearm(sleeve), 0.8f);
}

}  // namespace
}  // namespace dpl
