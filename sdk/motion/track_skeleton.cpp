// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/track_skeleton.h"

#include <algorithm>
#include <cmath>

#include "sdk/motion/track_points.h"

namespace dpl {
namespace {

constexpr float kLeastAcrossM = 0.02f;              // between left and right hip or shoulder, along hips that face the wrong way
constexpr float kOtherShare = 0.35f;                // by which a bone may differ from its rest length, after the scale of the whole
constexpr float kSmallest = 0.4f, kLargest = 2.5f;  // scale of a person against the rest pose
constexpr float kLargestOfAll = 20;                 // of any figure against a person of 1.7 m; other units are 100 or 1000 times off
constexpr size_t kLeastBones = 4;

struct BonePair {
    std::string_view from, to;
};
// A bone that is not tracked, as many models lack it, goes rigidly with the one that carries it. Carriers come first.
constexpr BonePair kRigid[] = {
    {"hips", "spine"},
    {"spine", "chest"},
    {"chest", "upperChest"},
    {"upperChest", "neck"},
    {"upperChest", "leftShoulder"},
    {"upperChest", "rightShoulder"},
    {"leftFoot", "leftToes"},
    {"rightFoot", "rightToes"},
};
constexpr BonePair kLengths[] = {
    {"leftUpperArm", "leftLowerArm"},  {"rightUpperArm", "rightLowerArm"}, {"leftLowerArm", "leftHand"},
    {"rightLowerArm", "rightHand"},    {"leftUpperLeg", "leftLowerLeg"},   {"rightUpperLeg", "rightLowerLeg"},
    {"leftLowerLeg", "leftFoot"},      {"rightLowerLeg", "rightFoot"},     {"hips", "head"},
    {"leftUpperArm", "rightUpperArm"},
};

}  // namespace

Result<TrackSkeleton> TrackSkeleton::create(std::span<const TrackedJoint> table, const CleanFrame& rest) {
    TrackSkeleton out;
    for (size_t j = 0; j < table.size(); ++j) {
        out.joints_.push_back({table[j].name, -1, Vec3f(0), table[j].bone});
        if (!table[j].bone.empty()) out.bones_.emplace(table[j].bone, j);
    }
    out.uprightFromJoint_.assign(table.size(), Quatf(1, 0, 0, 0));
    if (rest.positions.empty()) {
        out.rest_.assign(standardRest().begin(), standardRest().end());
        return out;
    }
    // Rest poses are looked at as frames of a person whose size the standard T-pose tells, by bone.
    std::vector<Vec3f> standard(table.size(), Vec3f(0));
    const auto names = humanoidBoneNames();
    for (const auto& [bone, joint] : out.bones_)
        if (const auto at = std::find(names.begin(), names.end(), bone); at != names.end())
            standard[joint] = standardRest()[size_t(at - names.begin())];
    std::vector<float> ratios;
    if (const float scale = out.scaleOf(rest, standard, ratios); scale > kLargestOfAll)
        return fail(Code::InvalidArgument, "rest: bones are {} times as long as a person's: metres are needed, these look like {}", scale,
                    scale > 300 ? "millimetres" : "centimetres");
    for (const std::string_view bone : {"hips", "head", "leftUpperArm", "rightUpperArm", "leftLowerArm", "rightLowerArm"}) {
        const auto joint = findBone(out.bones_, bone);
        if (joint && !rest.tracked[*joint])
            return fail(Code::InvalidArgument, "rest: joint '{}' has a number that is not finite, or a rotation of zero",
                        table[*joint].name);
    }
    std::erase_if(out.bones_, [&](const auto& entry) { return !rest.tracked[entry.second]; });  // bones that a model lacks
    out.rest_ = rest.positions;
    const auto upright = uprightFrom(out.bones_, out.rest_);
    if (!upright) return fail(Code::CorruptData, "rest: the joints are not those of a standing person; give the T-pose of the platform");
    for (Vec3f& p : out.rest_) p = *upright * p;
    for (size_t j = 0; j < table.size(); ++j) out.uprightFromJoint_[j] = glm::normalize(glm::conjugate(*upright * rest.rotations[j]));
    // Toes point ahead of ankles: else the names of the sides are swapped.
    float ahead = 0;
    for (const std::string side : {"left", "right"}) {
        const auto foot = findBone(out.bones_, side + "Foot"), toes = findBone(out.bones_, side + "Toes");
        if (foot && toes && rest.tracked[*foot] && rest.tracked[*toes]) ahead += out.rest_[*toes].z - out.rest_[*foot].z;
    }
    if (ahead < -0.05f)
        return fail(Code::CorruptData, "rest: toes point behind, so left and right are swapped, or the axes are left-handed");
    out.knowsLengths_ = true;
    return out;
}

bool TrackSkeleton::isSwapped(const CleanFrame& frame) const {
    const auto hips = findBone(bones_, "hips");
    if (!hips || !frame.tracked[*hips]) return false;
    const Vec3f left = frame.rotations[*hips] * Vec3f(1, 0, 0);
    for (const std::string part : {"UpperLeg", "UpperArm"}) {
        const auto a = findBone(bones_, "left" + part), b = findBone(bones_, "right" + part);
        if (!a || !b || !frame.tracked[*a] || !frame.tracked[*b]) continue;
        if (glm::dot(frame.positions[*a] - frame.positions[*b], left) < -kLeastAcrossM) return true;
        if (part == "UpperLeg") return false;  // hips carry the legs; a chest can turn far
    }
    return false;
}

/** How many times as long as at rest the bones of a frame are, in the median. 0: too few are tracked. */
float TrackSkeleton::scaleOf(const CleanFrame& frame, std::span<const Vec3f> rest, std::vector<float>& ratios) const {
    ratios.clear();
    for (const BonePair& pair : kLengths) {
        const auto a = findBone(bones_, pair.from), b = findBone(bones_, pair.to);
        if (!a || !b || !frame.tracked[*a] || !frame.tracked[*b]) continue;
        const float before = glm::length(rest[*b] - rest[*a]);
        if (before > 0.02f) ratios.push_back(glm::length(frame.positions[*b] - frame.positions[*a]) / before);
    }
    if (ratios.size() < kLeastBones) return 0;
    const auto middle = ratios.begin() + std::ptrdiff_t(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return *middle;
}

Status TrackSkeleton::checkLengths(const CleanFrame& frame) const {
    std::vector<float> ratios;
    const float scale = scaleOf(frame, rest_, ratios);
    if (ratios.size() < kLeastBones) return {};
    // Without a rest pose only the rotations are needed, and some programs give no places but that of the hips.
    const bool tooSmall = knowsLengths_ && !(scale > kSmallest);
    if (tooSmall || !(scale < (knowsLengths_ ? kLargest : kLargestOfAll)))
        return fail(Code::CorruptData, "bones are {} times as long as {}: metres are needed, of the skeleton that rest describes", scale,
                    knowsLengths_ ? "at rest" : "a person's");
    if (!knowsLengths_) return {};
    const auto other = std::count_if(ratios.begin(), ratios.end(), [&](float r) { return std::abs(r / scale - 1) > kOtherShare; });
    if (size_t(other) * 2 > ratios.size())
        return fail(Code::CorruptData, "{} of {} bones have other proportions than at rest: another skeleton, or joints in another order",
                    other, ratios.size());
    return {};
}

Status TrackSkeleton::read(CleanFrame& frame) const {
    for (size_t j = 0; j < joints_.size(); ++j)
        if (frame.tracked[j]) frame.rotations[j] = glm::normalize(frame.rotations[j] * uprightFromJoint_[j]);
    if (isSwapped(frame)) return fail(Code::CorruptData, "left and right of the hips or the arms are swapped");
    DPL_RETURN_IF_ERROR(checkLengths(frame));
    for (const BonePair& pair : kRigid) {
        const auto carrier = findBone(bones_, pair.from), bone = findBone(bones_, pair.to);
        if (!carrier || !bone || !frame.tracked[*carrier] || frame.tracked[*bone]) continue;
        frame.rotations[*bone] = frame.rotations[*carrier];
        frame.tracked[*bone] = 1;
    }
    return {};
}

}  // namespace dpl
