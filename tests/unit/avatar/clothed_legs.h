// SPDX-License-Identifier: Apache-2.0
// Hips and legs as tubes of a body layer, in a skirt whose nodes learned offsets of motion.
#pragma once

#include <cmath>

#include "sdk/avatar/rig.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {

constexpr float kLegM = 0.07f;  // radius

/** Vertices and triangles of a tube around a vertical axis, from `top` down to `bottom`; weigh gives joints and weights of a vertex. */
template <class Weigh>
void addTube(MeshData& mesh, const Vec3f& top, const Vec3f& bottom, float topM, float bottomM, uint32_t rings, const Weigh& weigh) {
    constexpr uint32_t kSides = 32;
    const auto first = uint32_t(mesh.restPositions.size());
    for (uint32_t r = 0; r <= rings; ++r)
        for (uint32_t s = 0; s < kSides; ++s) {
            const float down = float(r) / float(rings), angle = 6.2831853f * float(s) / kSides, radius = topM + down * (bottomM - topM);
            const Vec3f p = top + down * (bottom - top) + radius * Vec3f(std::cos(angle), 0, std::sin(angle));
            const PackedWeights packed = packWeights(weigh(p, down));
            mesh.restPositions.push_back(p);
            mesh.jointIndices.push_back(packed.joints), mesh.jointWeights.push_back(packed.weights);
        }
    for (uint32_t r = 0; r < rings; ++r)
        for (uint32_t s = 0; s < kSides; ++s) {
            const uint32_t p = first + r * kSides + s, q = first + r * kSides + (s + 1) % kSides;
            mesh.triangles.push_back({p, q, p + kSides});
            mesh.triangles.push_back({q, q + kSides, p + kSides});
        }
}

/** Joints: hips, spine, thighs 2 and 5, each with shin and foot. At rest no column is at work. */
inline AvatarData clothedLegs(uint32_t seed = 1) {
    AvatarData a;
    a.joints = {{"hips", -1, {0, 1, 0}, "hips"},
                {"spine", 0, {0, 1.15f, 0}, "spine"},
                {"thigh_l", 0, {0.1f, 0.95f, 0}, "leftUpperLeg"},
                {"shin_l", 2, {0.1f, 0.5f, 0}, "leftLowerLeg"},
                {"foot_l", 3, {0.1f, 0.08f, 0}, "leftFoot"},
                {"thigh_r", 0, {-0.1f, 0.95f, 0}, "rightUpperLeg"},
                {"shin_r", 5, {-0.1f, 0.5f, 0}, "rightLowerLeg"},
                {"foot_r", 6, {-0.1f, 0.08f, 0}, "rightFoot"}};
    using Shares = std::vector<std::pair<uint32_t, float>>;
    const auto all = [](uint32_t joint) { return [joint](const Vec3f&, float) { return Shares{{joint, 1.0f}}; }; };
    for (const uint32_t thigh : {2u, 5u}) {
        addTube(a.mesh, a.joints[thigh].restPosition, a.joints[thigh + 1].restPosition, kLegM, kLegM, 12, all(thigh));
        addTube(a.mesh, a.joints[thigh + 1].restPosition, a.joints[thigh + 2].restPosition, kLegM, kLegM, 12, all(thigh + 1));
    }
    addTube(a.mesh, {0, 1.15f, 0}, {0, 0.95f, 0}, 0.14f, 0.14f, 6, all(0));
    const auto vertices = uint32_t(a.mesh.restPositions.size()), triangles = uint32_t(a.mesh.triangles.size());
    addTube(a.mesh, {0, 1.1f, 0}, {0, 0.5f, 0}, 0.17f, 0.24f, 20, [](const Vec3f& p, float down) {
        const float left = std::clamp(0.5f + 3 * p.x, 0.0f, 1.0f), legs = 0.6f * down;
        return Shares{{0, 1 - legs}, {2, legs * left}, {5, legs * (1 - left)}};
    });
    a.mesh.layers = {{"body", "body", 0, vertices, 0, triangles},
                     {"skirt", "garment", vertices, uint32_t(a.mesh.restPositions.size()) - vertices, triangles,
                      uint32_t(a.mesh.triangles.size()) - triangles}};
    a.correctives = randomCorrectives(a, seed, {.nodes = 240, .offsetM = 0.02f, .motion = 2});
    std::fill(a.correctives.mean.begin(), a.correctives.mean.end(), 0.0f);
    for (Vec4f& still : a.correctives.motion.still) still = Vec4f(0, 0, 0, 1);
    for (Vec2f& range : a.correctives.motion.rangeRad) range = Vec2f(0.05f, 1);
    return a;
}

/** Both hips bent, radians: above 0 forward. */
inline Pose stride(float leftRad, float rightRad) {
    Pose pose = Pose::rest(8);
    pose.localRotations[2] = glm::angleAxis(-leftRad, Vec3f(1, 0, 0));
    pose.localRotations[5] = glm::angleAxis(-rightRad, Vec3f(1, 0, 0));
    return pose;
}

}  // namespace dpl::test
