// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/bone_follower.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/humanoid.h"
#include "sdk/motion/limb.h"

namespace dpl {

std::optional<Quatf> uprightFrom(const BoneMap& bones, std::span<const Vec3f> at) {
    const auto mean = [&](std::string_view a, std::string_view b) -> std::optional<Vec3f> {
        const auto i = findBone(bones, a), j = findBone(bones, b);
        if (i && j) return 0.5f * (at[*i] + at[*j]);
        return std::nullopt;
    };
    const auto spread = [&](std::string_view a, std::string_view b) -> std::optional<Vec3f> {
        const auto i = findBone(bones, a), j = findBone(bones, b);
        if (i && j) return at[*i] - at[*j];
        return std::nullopt;
    };
    const auto hips = findBone(bones, "hips"), head = findBone(bones, "head");
    if (!hips) return std::nullopt;
    auto low = mean("leftFoot", "rightFoot");
    if (!low) low = mean("leftLowerLeg", "rightLowerLeg");
    auto high = head ? std::optional(at[*head]) : mean("leftUpperArm", "rightUpperArm");
    if (!high) high = at[*hips];
    auto left = spread("leftUpperLeg", "rightUpperLeg");
    if (!left || glm::length(*left) < 1e-4f) left = spread("leftUpperArm", "rightUpperArm");
    if (!low && head) low = at[*hips];  // a skeleton without legs stands by its trunk
    if (!low || !left) return std::nullopt;
    const Vec3f legs = at[*hips] - *low, torso = *high - at[*hips];
    if (head && glm::length(legs) > 1e-3f && glm::dot(glm::normalize(legs), glm::normalize(torso)) < 0.7f)
        return std::nullopt;  // torso and legs not in line: not a standing rest pose
    Vec3f up = *high - *low;
    if (!(glm::length(up) > 1e-3f) || !(glm::length(*left) > 1e-4f)) return std::nullopt;
    const auto snap = [](const Vec3f& v) {  // the nearest axis if it is within 30°
        const Vec3f unit = glm::normalize(v);
        for (int axis = 0; axis < 3; ++axis)
            if (std::abs(unit[axis]) > 0.866f) {
                Vec3f snapped(0);
                snapped[axis] = unit[axis] > 0 ? 1.0f : -1.0f;
                return snapped;
            }
        return unit;
    };
    up = snap(up);
    Vec3f side = *left - up * glm::dot(*left, up);
    if (!(glm::length(side) > 1e-4f)) return std::nullopt;
    side = snap(side);
    const Vec3f forward = glm::cross(side, up);
    return glm::normalize(glm::quat_cast(glm::transpose(Mat3f(side, up, forward))));
}

Status checkCommonBones(std::string_view sourceName, std::span<const JointData> source, const BoneMap& sourceBones,
                        std::span<const JointData> target, const BoneMap& targetBones) {
    const auto both = [&](std::string_view bone) { return findBone(sourceBones, bone) && findBone(targetBones, bone); };
    const bool legs = both("leftUpperLeg") && both("rightUpperLeg"), arms = both("leftUpperArm") && both("rightUpperArm");
    if (both("hips") && (legs || arms)) return {};
    const auto list = [](std::span<const JointData> joints) {
        std::string text;
        for (const JointData& joint : joints) text += (text.empty() ? "" : ", ") + joint.name;
        return text;
    };
    const bool sourceLacks =
        !findBone(sourceBones, "hips") || (!findBone(sourceBones, "leftUpperLeg") && !findBone(sourceBones, "leftUpperArm"));
    return fail(Code::Unsupported, "{}: the {} skeleton has no recognisable hips with arms or legs; its joints are: {}", sourceName,
                sourceLacks ? "motion's" : "avatar's", sourceLacks ? list(source) : list(target));
}

namespace {

struct LimbBone {
    std::string_view bone, next, parent;  // the bone points to `next`; its alignment starts from that of `parent`
};

constexpr LimbBone kLimbs[] = {
    {"UpperArm", "LowerArm", ""},
    {"LowerArm", "Hand", "UpperArm"},
    {"Hand", "MiddleProximal", "LowerArm"},
    {"UpperLeg", "LowerLeg", ""},
    {"LowerLeg", "Foot", "UpperLeg"},
    {"ThumbMetacarpal", "ThumbProximal", "Hand"},
    {"ThumbProximal", "ThumbDistal", "ThumbMetacarpal"},
    {"ThumbDistal", "", "ThumbProximal"},
    {"IndexProximal", "IndexIntermediate", "Hand"},
    {"IndexIntermediate", "IndexDistal", "IndexProximal"},
    {"IndexDistal", "", "IndexIntermediate"},
    {"MiddleProximal", "MiddleIntermediate", "Hand"},
    {"MiddleIntermediate", "MiddleDistal", "MiddleProximal"},
    {"MiddleDistal", "", "MiddleIntermediate"},
    {"RingProximal", "RingIntermediate", "Hand"},
    {"RingIntermediate", "RingDistal", "RingProximal"},
    {"RingDistal", "", "RingIntermediate"},
    {"LittleProximal", "LittleIntermediate", "Hand"},
    {"LittleIntermediate", "LittleDistal", "LittleProximal"},
    {"LittleDistal", "", "LittleIntermediate"},
};

/** The child of a joint that has exactly one, such as an end site or a fingertip. */
std::optional<size_t> onlyChild(std::span<const JointData> joints, size_t joint) {
    std::optional<size_t> child;
    for (size_t j = joint + 1; j < joints.size(); ++j)
        if (joints[j].parent == int32_t(joint)) {
            if (child) return std::nullopt;
            child = j;
        }
    return child;
}

}  // namespace

BoneFollower::BoneFollower(std::span<const JointData> source, const BoneMap& sourceBones, std::span<const Vec3f> sourceRest,
                           std::span<const JointData> target)
    : source_(source), target_(target), sourceBones_(sourceBones), sourceRest_(sourceRest), bones_(bonesOf(target)) {
    mapBones();
}

void BoneFollower::mapBones() {
    for (const auto& [bone, joint] : bones_)
        if (const auto from = findBone(sourceBones_, bone)) driven_.push_back({joint, *from, Quatf(1, 0, 0, 0), Vec3f(0), std::nullopt});
    // The top of the spine carries the arms. If the target has fewer spine bones, its last one follows the last one of the source.
    if (auto top = topOfSpine(bones_), from = topOfSpine(sourceBones_); top && from)
        if (Driven* d = drivenBy(*top)) d->source = *from;
    std::sort(driven_.begin(), driven_.end(), [](const Driven& a, const Driven& b) { return a.target < b.target; });
    for (const char* side : {"left", "right"})
        for (size_t limb = 0; limb < std::size(kLimbs); ++limb) alignLimb(side, limb);
    for (const char* side : {"left", "right"}) alignPalm(side);
}

BoneFollower::Driven* BoneFollower::drivenBy(size_t targetJoint) {
    for (Driven& d : driven_)
        if (d.target == targetJoint) return &d;
    return nullptr;
}

BoneFollower::Driven* BoneFollower::drivenBone(std::string_view bone) {
    const auto joint = findBone(bones_, bone);
    return joint ? drivenBy(*joint) : nullptr;
}

void BoneFollower::alignLimb(const std::string& side, size_t index) {
    const LimbBone& limb = kLimbs[index];
    Driven* d = drivenBone(side + std::string(limb.bone));
    if (!d) return;
    const Driven* parent = limb.parent.empty() ? nullptr : drivenBone(side + std::string(limb.parent));
    if (parent) d->align = parent->align;
    std::optional<size_t> targetNext, sourceNext;
    if (!limb.next.empty()) {
        targetNext = findBone(bones_, side + std::string(limb.next));
        sourceNext = findBone(sourceBones_, side + std::string(limb.next));
    }
    if (!targetNext || !sourceNext) {  // last mapped bone of its chain: needs a tip in both skeletons
        if (limb.bone == "Hand") return;
        targetNext = onlyChild(target_, d->target);
        sourceNext = onlyChild(source_, d->source);
    }
    if (!targetNext || !sourceNext) return;
    const Vec3f to = target_[*targetNext].restPosition - target_[d->target].restPosition;
    const Vec3f from = sourceRest_[*sourceNext] - sourceRest_[d->source];
    if (!(glm::length(to) > 1e-5f) || !(glm::length(from) > 1e-5f)) return;
    d->restDirection = glm::normalize(to);
    d->align = glm::normalize(shortestTurn(d->align * d->restDirection, from) * d->align);
    d->sourceNext = sourceNext;
}

/** Aligns the roll of a hand about its own direction, by the line from the little finger to the index finger. The forearm takes half of
 *  the roll. */
void BoneFollower::alignPalm(const std::string& side) {
    Driven* hand = drivenBone(side + "Hand");
    const auto across = [&](const BoneMap& bones, auto&& at) -> std::optional<Vec3f> {
        const auto index = findBone(bones, side + "IndexProximal");
        auto little = findBone(bones, side + "LittleProximal");
        if (!little) little = findBone(bones, side + "RingProximal");
        if (!index || !little) return std::nullopt;
        return at(*index) - at(*little);
    };
    if (!hand || !hand->sourceNext) return;
    const auto to = across(bones_, [&](size_t j) { return target_[j].restPosition; });
    const auto from = across(sourceBones_, [&](size_t j) { return sourceRest_[j]; });
    if (!to || !from) return;
    const Vec3f axis = glm::normalize(hand->align * hand->restDirection);
    const Vec3f a = hand->align * *to, b = *from;
    const Vec3f flatA = a - axis * glm::dot(a, axis), flatB = b - axis * glm::dot(b, axis);
    if (!(glm::length(flatA) > 1e-4f) || !(glm::length(flatB) > 1e-4f)) return;
    const float roll = std::atan2(glm::dot(axis, glm::cross(flatA, flatB)), glm::dot(flatA, flatB));
    if (std::abs(roll) > glm::radians(120.0f)) return;  // no wrist can: one of the skeletons names its fingers in another order
    hand->align = glm::angleAxis(roll, axis) * hand->align;
    if (Driven* arm = drivenBone(side + "LowerArm"); arm && arm->sourceNext)
        arm->align = glm::angleAxis(0.5f * roll, glm::normalize(arm->align * arm->restDirection)) * arm->align;
    for (size_t limb = 0; limb < std::size(kLimbs); ++limb)  // fingers inherit the roll of the hand
        if (kLimbs[limb].bone != "Hand" && kLimbs[limb].parent != "" && kLimbs[limb].bone.find("Arm") == std::string_view::npos &&
            kLimbs[limb].bone.find("Leg") == std::string_view::npos)
            alignLimb(side, limb);
}

float BoneFollower::travelScale() const {
    const auto legs = [](const BoneMap& bones, auto&& at) {
        float sum = 0;
        for (const std::string side : {"left", "right"}) {
            const auto hip = findBone(bones, side + "UpperLeg"), knee = findBone(bones, side + "LowerLeg"),
                       foot = findBone(bones, side + "Foot");
            if (!hip || !knee || !foot) return 0.0f;
            sum += glm::length(at(*hip) - at(*knee)) + glm::length(at(*knee) - at(*foot));
        }
        return sum;
    };
    const auto height = [](size_t hips, size_t count, auto&& at) {
        float lowest = 1e30f;
        for (size_t j = 0; j < count; ++j) lowest = std::min(lowest, at(j).y);
        return at(hips).y - lowest;
    };
    const auto targetAt = [&](size_t j) { return target_[j].restPosition; };
    const auto sourceAt = [&](size_t j) { return sourceRest_[j]; };
    float a = legs(bones_, targetAt), b = legs(sourceBones_, sourceAt);
    if (!(a > 1e-3f) || !(b > 1e-3f)) {
        a = height(*findBone(bones_, "hips"), target_.size(), targetAt);
        b = height(*findBone(sourceBones_, "hips"), source_.size(), sourceAt);
    }
    return a > 1e-3f && b > 1e-3f ? a / b : 1.0f;
}

void BoneFollower::pose(std::span<const Quatf> rotations, std::span<const Vec3f> positions, std::span<const uint8_t> tracked,
                        std::span<Quatf> localRotations) {
    world_.resize(target_.size());
    positions_.resize(target_.size());
    size_t next = 0;
    for (size_t j = 0; j < target_.size(); ++j) {
        const int32_t parent = target_[j].parent;
        const Quatf above = parent < 0 ? Quatf(1, 0, 0, 0) : world_[size_t(parent)];
        positions_[j] = parent < 0 ? target_[j].restPosition
                                   : positions_[size_t(parent)] + above * (target_[j].restPosition - target_[size_t(parent)].restPosition);
        const bool follows = next < driven_.size() && driven_[next].target == j;
        const Driven* d = follows ? &driven_[next++] : nullptr;
        if (!d || (!tracked.empty() && !tracked[d->source])) {
            world_[j] = glm::normalize(above * localRotations[j]);
            continue;
        }
        Quatf turned = glm::normalize(rotations[d->source] * d->align);
        if (d->sourceNext && !positions.empty())
            turned = glm::normalize(shortestTurn(turned * d->restDirection, positions[*d->sourceNext] - positions[d->source]) * turned);
        world_[j] = turned;
        localRotations[j] = glm::normalize(glm::conjugate(above) * turned);
    }
}

}  // namespace dpl
