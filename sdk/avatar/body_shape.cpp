// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/body_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

constexpr size_t kLeastVertices = 12;
constexpr float kLeastHandM = 0.008f, kMostHandM = 0.03f, kMostLowerArmM = 0.06f, kMostUpperArmM = 0.08f;

float percentile(std::vector<float>& values, float share) {
    const auto at = values.begin() + std::ptrdiff_t(share * float(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

/** Median distance of a joint's vertices from the bone between two points, metres; none where the mesh or the bone is too small. */
std::optional<float> thicknessOf(const MeshData& mesh, size_t joint, const Vec3f& from, const Vec3f& to) {
    if (!(glm::length(to - from) > 0.01f)) return std::nullopt;
    std::vector<float> distances;
    for (size_t v = 0; v < mesh.restPositions.size(); ++v)
        if (ownerOf(mesh, v) == joint)
            distances.push_back(glm::length(glm::cross(mesh.restPositions[v] - from, glm::normalize(to - from))));
    if (distances.size() < kLeastVertices) return std::nullopt;
    return percentile(distances, 0.5f);
}

}  // namespace

BodyShape BodyShape::of(std::span<const JointData> joints, const MeshData& mesh) {
    BodyShape shape;
    const BoneMap bones = bonesOf(joints);
    const auto add = [&](std::string_view bone, std::initializer_list<std::string_view> next) {
        const auto joint = findBone(bones, bone);
        if (!joint) return;
        for (const std::string_view to : next)
            if (const auto target = findBone(bones, to)) {
                if (auto tube = BodyTube::of(joints, mesh, 0, mesh.restPositions.size(), *joint, joints[*target].restPosition))
                    shape.tubes_.push_back(std::move(*tube));
                return;
            }
    };
    add("hips", {"spine", "chest", "neck", "head"}), add("spine", {"chest", "upperChest", "neck", "head"});
    add("chest", {"upperChest", "neck", "head"}), add("upperChest", {"neck", "head"});
    for (size_t side = 0; side < 2; ++side) {
        const std::string s = side == 0 ? "left" : "right";
        add(s + "UpperLeg", {s + "LowerLeg"});
        const auto hand = findBone(bones, s + "Hand"), lower = findBone(bones, s + "LowerArm"), upper = findBone(bones, s + "UpperArm"),
                   index = findBone(bones, s + "IndexProximal"), little = findBone(bones, s + "LittleProximal");
        if (!hand || !lower) continue;
        const Vec3f wrist = joints[*hand].restPosition, elbow = joints[*lower].restPosition;
        shape.lowerArmM_[side] = std::min(thicknessOf(mesh, *lower, elbow, wrist).value_or(shape.lowerArmM_[side]), kMostLowerArmM);
        if (upper)
            shape.upperArmM_[side] =
                std::min(thicknessOf(mesh, *upper, joints[*upper].restPosition, elbow).value_or(shape.upperArmM_[side]), kMostUpperArmM);
        Vec3f normal(0);
        if (index && little) normal = glm::cross(joints[*index].restPosition - wrist, joints[*little].restPosition - wrist);
        if (!(glm::length(normal) > 1e-6f)) continue;
        std::vector<float> thick;
        for (size_t v = 0; v < mesh.restPositions.size(); ++v)
            if (ownerOf(mesh, v) == *hand) thick.push_back(glm::dot(mesh.restPositions[v] - wrist, glm::normalize(normal)));
        if (thick.size() >= kLeastVertices)
            shape.handM_[side] = std::clamp(0.5f * (percentile(thick, 0.9f) - percentile(thick, 0.1f)), kLeastHandM, kMostHandM);
    }
    return shape;
}

std::optional<BodyShape::Inside> BodyShape::inside(const Vec3f& centre, float radiusM, std::span<const Mat3x4f> worldFromRest) const {
    std::optional<Inside> deepest;
    for (const BodyTube& tube : tubes_) {
        const Mat3x4f& g = worldFromRest[tube.joint];
        const Mat3f turn(g);
        const Vec3f local = tube.localOf(glm::transpose(turn) * (centre - g[3]));
        const auto place = tube.placeOf(local);
        if (!place) continue;
        const float depth = place->share * (place->radiusM + radiusM - place->distanceM);
        if (depth <= 0 || (deepest && depth <= deepest->depthM)) continue;
        deepest = Inside{depth, glm::normalize(turn * ((tube.across * local.y + tube.third * local.z) / place->distanceM))};
    }
    return deepest;
}

}  // namespace dpl
