// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/body_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

constexpr float kTau = 6.2831853f;
constexpr size_t kLeastVertices = 12;
constexpr float kTaperM = 0.03f;  // at the ends of a tube its depth falls to zero over this length
constexpr float kLeastHandM = 0.008f, kMostHandM = 0.03f, kMostLowerArmM = 0.06f, kMostUpperArmM = 0.08f;
constexpr int kStrong = 128;  // of 255: a vertex belongs to the joint that has half of its weight

/** Joint that has at least half of a vertex; none for vertices between joints. */
std::optional<size_t> ownerOf(const MeshData& mesh, size_t vertex) {
    for (int i = 0; i < 4; ++i)
        if (mesh.jointWeights[vertex][i] >= kStrong) return mesh.jointIndices[vertex][i];
    return std::nullopt;
}

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

std::optional<BodyShape::Tube> BodyShape::tubeOf(std::span<const JointData> joints, const MeshData& mesh, size_t joint, const Vec3f& to) {
    Tube tube;
    tube.joint = joint;
    tube.from = joints[joint].restPosition;
    if (!(glm::length(to - tube.from) > 0.01f)) return std::nullopt;
    tube.along = glm::normalize(to - tube.from);
    const Vec3f ahead(0, 0, 1), other(1, 0, 0);
    const Vec3f side = std::abs(tube.along.z) < 0.9f ? ahead : other;
    tube.across = glm::normalize(side - tube.along * glm::dot(side, tube.along));
    tube.third = glm::cross(tube.along, tube.across);
    std::vector<Vec3f> at;  // along, radius, angle
    for (size_t v = 0; v < mesh.restPositions.size(); ++v) {
        if (ownerOf(mesh, v) != joint) continue;
        const Vec3f p = mesh.restPositions[v] - tube.from;
        const float x = glm::dot(p, tube.across), y = glm::dot(p, tube.third);
        at.push_back({glm::dot(p, tube.along), std::hypot(x, y), std::atan2(y, x)});
    }
    if (at.size() < kLeastVertices) return std::nullopt;
    tube.beginM = tube.endM = at[0].x;
    for (const Vec3f& p : at) tube.beginM = std::min(tube.beginM, p.x), tube.endM = std::max(tube.endM, p.x);
    if (tube.endM - tube.beginM < 0.01f) return std::nullopt;
    tube.radiiM.assign(kAlong * kAround, 0.0f);
    for (const Vec3f& p : at) {
        const size_t k = std::min(size_t((p.x - tube.beginM) / (tube.endM - tube.beginM) * float(kAlong)), kAlong - 1);
        const size_t a = size_t((p.z / kTau + 1.5f) * float(kAround)) % kAround;
        float& radius = tube.radiiM[k * kAround + a];
        radius = std::max(radius, p.y);
    }
    // Cells without vertices take the mean of the nearest ones around, of the same ring.
    for (size_t k = 0; k < kAlong; ++k) {
        const std::vector<float> ring(tube.radiiM.begin() + std::ptrdiff_t(k * kAround),
                                      tube.radiiM.begin() + std::ptrdiff_t((k + 1) * kAround));
        for (size_t a = 0; a < kAround; ++a) {
            if (ring[a] > 0) continue;
            float sum = 0;
            for (const int way : {1, -1})
                for (size_t n = 1; n <= kAround / 4; ++n)
                    if (const float r = ring[size_t(int(a + kAround) + way * int(n)) % kAround]; r > 0) {
                        sum += 0.5f * r;
                        break;
                    }
            tube.radiiM[k * kAround + a] = sum;
        }
    }
    return tube;
}

float BodyShape::Tube::radiusAt(float alongM, float angleRad) const {
    const float k = std::clamp((alongM - beginM) / (endM - beginM) * float(kAlong) - 0.5f, 0.0f, float(kAlong - 1));
    const float a = (angleRad / kTau + 1.5f) * float(kAround) - 0.5f;
    const size_t k0 = size_t(k), k1 = std::min(k0 + 1, kAlong - 1), a0 = size_t(a) % kAround, a1 = (a0 + 1) % kAround;
    const float u = k - float(k0), v = a - std::floor(a);
    const auto at = [&](size_t i, size_t j) { return radiiM[i * kAround + j]; };
    return (1 - u) * ((1 - v) * at(k0, a0) + v * at(k0, a1)) + u * ((1 - v) * at(k1, a0) + v * at(k1, a1));
}

BodyShape BodyShape::of(std::span<const JointData> joints, const MeshData& mesh) {
    BodyShape shape;
    const BoneMap bones = bonesOf(joints);
    const auto add = [&](std::string_view bone, std::initializer_list<std::string_view> next) {
        const auto joint = findBone(bones, bone);
        if (!joint) return;
        for (const std::string_view to : next)
            if (const auto target = findBone(bones, to)) {
                if (auto tube = tubeOf(joints, mesh, *joint, joints[*target].restPosition)) shape.tubes_.push_back(std::move(*tube));
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
    for (const Tube& tube : tubes_) {
        const Mat3x4f& g = worldFromRest[tube.joint];
        const Mat3f turn(g);
        const Vec3f p = glm::transpose(turn) * (centre - g[3]) - tube.from;
        const float along = glm::dot(p, tube.along), x = glm::dot(p, tube.across), y = glm::dot(p, tube.third), distance = std::hypot(x, y);
        const float taper = std::min({(along - tube.beginM) / kTaperM + 1, (tube.endM - along) / kTaperM + 1, 1.0f});
        if (taper <= 0 || distance < 1e-4f) continue;
        const float radius = tube.radiusAt(along, std::atan2(y, x));
        if (radius <= 0) continue;
        const float depth = taper * (radius + radiusM - distance);
        if (depth <= 0 || (deepest && depth <= deepest->depthM)) continue;
        deepest = Inside{depth, glm::normalize(turn * ((tube.across * x + tube.third * y) / distance))};
    }
    return deepest;
}

}  // namespace dpl
