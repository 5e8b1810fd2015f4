// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/garments/cloth_weights.h"

#include <cmath>

#include <gtest/gtest.h>

#include "reconstruction/shape/closest_surface.h"
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

TEST(ClothWeights, aSkirtGoesWithAThighThatWouldComeThroughIt) {
    // Two legs as closed-in tubes, each on its joint, and a skirt 5 cm off them. Half way between the legs it hangs free.
    const std::vector<JointData> joints{joint("hips", -1, {0, 0.9f, 0}), joint("leftUpperLeg", 0, {0.1f, 0.9f, 0}),
                                        joint("rightUpperLeg", 0, {-0.1f, 0.9f, 0}), joint("leftLowerLeg", 1, {0.1f, 0.4f, 0}),
                                        joint("rightLowerLeg", 2, {-0.1f, 0.4f, 0})};
    MeshData body;
    for (const uint16_t leg : {uint16_t(1), uint16_t(2)}) {
        const SurfaceMesh mesh = tube({leg == 1 ? 0.1f : -0.1f, 0, 0}, 0.08f, 0.1f, 0.9f);
        const auto first = uint32_t(body.restPositions.size());
        for (const Vec3f& p : mesh.positions)
            body.restPositions.push_back(p), body.jointIndices.push_back({leg, 0, 0, 0}), body.jointWeights.push_back({255, 0, 0, 0});
        for (const Triangle& t : mesh.triangles) body.triangles.push_back(t + first);
    }
    const SurfaceMesh skirt = tube({0, 0, 0}, 0.23f, 0.45f, 0.9f);
    Jobs jobs(2);
    std::vector<Mat3x4f> atRest;
    jointTransforms(joints, Pose::rest(joints.size()), atRest);
    const ClothWeights held = must(clothWeights(skirt, body, joints, atRest, jobs));
    std::vector<JointData> nameless = joints;  // no humanoid bones, so no stress poses
    for (JointData& j : nameless) j.name = j.humanoidBone = "";
    const ClothWeights free = must(clothWeights(skirt, body, nameless, atRest, jobs));

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

}  // namespace
}  // namespace dpl
