// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/body_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "sdk/avatar/bone_follower.h"
#include "sdk/avatar/limb.h"

namespace dpl {
namespace {

constexpr float kTau = 6.2831853f;
constexpr size_t kLeastVertices = 12;
constexpr float kTaperM = 0.03f;  // at the ends of a tube its depth falls to zero over this length
constexpr float kLeastHandM = 0.008f, kMostHandM = 0.03f, kMostLowerArmM = 0.06f, kMostUpperArmM = 0.08f;
constexpr int kRounds = 4;
constexpr float kFingerShare = 0.65f;  // thickness of a finger over that of the palm
constexpr float kTouchM = 0.0005f;     // less than this deep is touching
constexpr int kStrong = 128;           // of 255: a vertex belongs to the joint that has half of its weight

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

ArmGuard::ArmGuard(BodyShape body, std::span<const JointData> joints) : body_(std::move(body)), joints_(joints) {
    if (body_.empty()) return;
    const BoneMap bones = bonesOf(joints);
    for (size_t side = 0; side < 2; ++side) {
        const std::string s = side == 0 ? "left" : "right";
        const auto upper = findBone(bones, s + "UpperArm"), lower = findBone(bones, s + "LowerArm"), hand = findBone(bones, s + "Hand");
        if (!upper || !lower || !hand || joints[*upper].parent < 0 || joints[*hand].parent != int32_t(*lower) ||
            joints[*lower].parent != int32_t(*upper))
            continue;
        const Vec3f shoulder = joints[*upper].restPosition, elbow = joints[*lower].restPosition, wrist = joints[*hand].restPosition;
        Arm& arm = arms_[side];
        arm.upper = *upper, arm.lower = *lower, arm.hand = *hand;
        const float thickM = body_.handM(side);
        arm.elbowBalls = {{*lower, elbow, kFirmShare * body_.lowerArmM(side), 1},
                          {*upper, 0.5f * (shoulder + elbow), kFirmShare * body_.upperArmM(side), 0.5f}};
        arm.wristBalls = {{*hand, wrist, thickM, 1}, {*lower, 0.5f * (elbow + wrist), body_.lowerArmM(side), 0.7f}};
        for (const char* finger : {"Index", "Middle", "Little"}) {
            const auto proximal = findBone(bones, s + finger + "Proximal"), middle = findBone(bones, s + finger + "Intermediate"),
                       distal = findBone(bones, s + finger + "Distal");
            if (!proximal || !middle || !distal) continue;
            const Vec3f last = joints[*distal].restPosition;
            arm.wristBalls.push_back({*hand, joints[*proximal].restPosition, thickM, 1});
            arm.wristBalls.push_back({*proximal, joints[*middle].restPosition, kFingerShare * thickM, 1});
            arm.wristBalls.push_back({*distal, last + 0.5f * (last - joints[*middle].restPosition), kFingerShare * thickM, 1});
        }
    }
}

/** By how much a joint must move so that none of the balls lies in the body. `swing` has turned them about the shoulder. */
Vec3f ArmGuard::pushFor(std::span<const Ball> balls, const Vec3f& shoulder, const Quatf& swing) const {
    Vec3f push(0);
    for (int round = 0; round < kRounds; ++round) {
        float deepest = kTouchM;
        Vec3f step(0);
        for (const Ball& ball : balls) {
            const Vec3f unmoved = world_[ball.joint] * Vec4f(ball.rest, 1);
            const Vec3f centre = shoulder + swing * (unmoved - shoulder) + ball.share * push;
            const auto in = body_.inside(centre, ball.radiusM, world_);
            if (in && in->depthM > deepest) deepest = in->depthM, step = in->outward * (in->depthM / ball.share);
        }
        if (step == Vec3f(0)) break;
        push += step;
    }
    const float length = glm::length(push);
    return length > kFarthestPushM ? push * (kFarthestPushM / length) : push;
}

/** The turn about the shoulder that moves the elbow towards where it is pushed. */
Quatf ArmGuard::swingFor(const Arm& arm, const Vec3f& elbowPush) const {
    const Vec3f along = jointAt(arm.lower) - jointAt(arm.upper);
    return shortestTurn(along, along + elbowPush);
}

Vec3f ArmGuard::jointAt(size_t joint) const {
    return world_[joint] * Vec4f(joints_[joint].restPosition, 1);
}

ArmGuard::Pushes ArmGuard::pushes(const Pose& pose) {
    Pushes out{};
    if (body_.empty()) return out;
    jointTransforms(joints_, pose, world_);
    for (size_t side = 0; side < 2; ++side) {
        const Arm& arm = arms_[side];
        if (arm.wristBalls.empty()) continue;
        const Vec3f shoulder = jointAt(arm.upper);
        out[side].elbow = pushFor(arm.elbowBalls, shoulder, Quatf(1, 0, 0, 0));
        out[side].wrist = pushFor(arm.wristBalls, shoulder, swingFor(arm, out[side].elbow));
    }
    return out;
}

void ArmGuard::push(const Pushes& pushes, Pose& pose) {
    if (pushes[0].none() && pushes[1].none()) return;
    jointTransforms(joints_, pose, world_);
    for (size_t side = 0; side < 2; ++side) {
        const Arm& arm = arms_[side];
        if (arm.wristBalls.empty() || pushes[side].none()) continue;
        const auto turned = [&](size_t joint) { return glm::normalize(glm::quat_cast(Mat3f(world_[joint]))); };
        const Quatf above = turned(size_t(joints_[arm.upper].parent)), swing = swingFor(arm, pushes[side].elbow);
        const Vec3f shoulder = jointAt(arm.upper), out = above * Vec3f(side == 0 ? 1.0f : -1.0f, 0, -0.5f);
        const auto swung = [&](size_t joint) { return shoulder + swing * (jointAt(joint) - shoulder); };
        const Vec3f elbow = swung(arm.lower), wrist = swung(arm.hand);
        const auto turn = reachWith({shoulder, elbow, wrist}, wrist + pushes[side].wrist, out);
        const Quatf upper = turn[0] * swing * turned(arm.upper), lower = turn[1] * swing * turned(arm.lower);
        pose.localRotations[arm.upper] = glm::normalize(glm::conjugate(above) * upper);
        pose.localRotations[arm.lower] = glm::normalize(glm::conjugate(upper) * lower);
        pose.localRotations[arm.hand] = glm::normalize(glm::conjugate(lower) * swing * turned(arm.hand));
    }
}

}  // namespace dpl
