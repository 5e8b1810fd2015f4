// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/retarget.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "sdk/avatar/humanoid.h"
#include "sdk/avatar/limb.h"
#include "sdk/avatar/plant_feet.h"
#include "sdk/avatar/rig.h"

namespace dpl {
namespace {

const Quatf kIdentity(1, 0, 0, 0);

float angleBetween(const Quatf& a, const Quatf& b) {
    return 2 * std::acos(std::min(1.0f, std::abs(glm::dot(a, b))));
}

using BoneMap = std::map<std::string, size_t, std::less<>>;  // humanoid bone -> joint

BoneMap bonesOf(std::span<const JointData> joints) {
    BoneMap map;
    const std::vector<std::string> bones = humanoidBones(joints);
    for (size_t j = 0; j < bones.size(); ++j)
        if (!bones[j].empty()) map.emplace(bones[j], j);
    return map;
}

std::optional<size_t> find(const BoneMap& bones, std::string_view bone) {
    const auto at = bones.find(bone);
    return at == bones.end() ? std::nullopt : std::optional(at->second);
}

/** The rotation that turns up and forward of a skeleton at rest to +Y and +Z. Both are snapped to an axis, so a small lean stays. Empty if
 *  the skeleton does not stand. */
std::optional<Quatf> uprightFrom(const BoneMap& bones, std::span<const Vec3f> at) {
    const auto mean = [&](std::string_view a, std::string_view b) -> std::optional<Vec3f> {
        const auto i = find(bones, a), j = find(bones, b);
        if (i && j) return 0.5f * (at[*i] + at[*j]);
        return std::nullopt;
    };
    const auto spread = [&](std::string_view a, std::string_view b) -> std::optional<Vec3f> {
        const auto i = find(bones, a), j = find(bones, b);
        if (i && j) return at[*i] - at[*j];
        return std::nullopt;
    };
    const auto hips = find(bones, "hips"), head = find(bones, "head");
    if (!hips) return std::nullopt;
    auto low = mean("leftFoot", "rightFoot");
    if (!low) low = mean("leftLowerLeg", "rightLowerLeg");
    auto high = head ? std::optional(at[*head]) : mean("leftUpperArm", "rightUpperArm");
    if (!high) high = at[*hips];
    auto left = spread("leftUpperLeg", "rightUpperLeg");
    if (!left || glm::length(*left) < 1e-4f) left = spread("leftUpperArm", "rightUpperArm");
    if (!low || !left) return std::nullopt;
    const Vec3f legs = at[*hips] - *low, torso = *high - at[*hips];
    if (head && glm::dot(glm::normalize(legs), glm::normalize(torso)) < 0.7f)
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

/** World rotations D and positions of the source at every key, turned so that it stands along +Y and faces +Z. D is relative to a standing
 *  rest pose. */
class UprightSource {
public:
    explicit UprightSource(const Motion& motion) : motion_(motion), bones_(bonesOf(motion.joints)) {
        rest_.reserve(motion.joints.size());
        for (const JointData& joint : motion.joints) rest_.push_back(joint.restPosition);
        restInverse_.assign(rest_.size(), kIdentity);
        auto upright = uprightFrom(bones_, rest_);
        if (!upright && motion.keyCount() > 0) {  // the rest pose does not stand: use the first frame instead
            std::vector<Quatf> rotations;
            motionAt(motion, 0, rotations, rest_);
            for (size_t j = 0; j < rest_.size(); ++j) restInverse_[j] = glm::conjugate(rotations[j]);
            upright = uprightFrom(bones_, rest_);
        }
        upright_ = upright.value_or(kIdentity);
        for (Vec3f& p : rest_) p = upright_ * p;
    }

    const BoneMap& bones() const { return bones_; }
    std::span<const Vec3f> rest() const { return rest_; }
    void at(size_t key, std::vector<Quatf>& rotations, std::vector<Vec3f>& positions) const {
        motionAt(motion_, key, rotations, positions);
        for (size_t j = 0; j < rotations.size(); ++j) {
            rotations[j] = upright_ * rotations[j] * restInverse_[j] * glm::conjugate(upright_);
            positions[j] = upright_ * positions[j];
        }
    }

private:
    const Motion& motion_;
    BoneMap bones_;
    std::vector<Vec3f> rest_;
    std::vector<Quatf> restInverse_;
    Quatf upright_ = kIdentity;
};

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

/** A target joint that follows a source joint. */
struct Driven {
    size_t target = 0, source = 0;
    Quatf align = kIdentity;           // A_k of retarget.h
    Vec3f restDirection{0};            // direction of the target bone at rest, unit; zero: none
    std::optional<size_t> sourceNext;  // source joint that the bone points to; set if the direction must match exactly
};

class Retargeter {
public:
    Retargeter(const Motion& motion, std::span<const JointData> target)
        : motion_(motion), source_(motion), target_(target), bones_(bonesOf(target)) {}

    Result<ClipData> run(const RetargetOptions& options) {
        DPL_CHECK_OK(checkCommon());
        mapBones();
        if (options.levelHead) levelHead();
        const size_t first = options.keepLeadIn ? 0 : firstKey();
        ClipData clip;
        clip.name = motion_.name;
        for (size_t k = first; k < motion_.keyCount(); ++k) clip.timesS.push_back(motion_.timesS[k] - motion_.timesS[first]);
        for (const Driven& d : driven_) clip.channels.push_back({uint32_t(d.target), {}});
        for (ClipChannel& channel : clip.channels) channel.rotations.reserve(clip.timesS.size());
        std::vector<float> clearance;
        for (size_t k = first; k < motion_.keyCount(); ++k) addKey(k, clip, clearance);
        place(options, clearance, clip);
        if (options.plantFeet) plantFeet(target_, clip);
        for (const ClipChannel& channel : clip.channels)
            for (const Quatf& q : channel.rotations)
                if (!std::isfinite(q.w + q.x + q.y + q.z))
                    return fail(Code::CorruptData, "{}: the motion of '{}' is not finite", motion_.name, target_[channel.joint].name);
        for (const Vec3f& t : clip.rootTranslations)
            if (!std::isfinite(t.x + t.y + t.z)) return fail(Code::CorruptData, "{}: the travel of the hips is not finite", motion_.name);
        return clip;
    }

private:
    Status checkCommon() const {
        const auto both = [&](std::string_view bone) { return find(source_.bones(), bone) && find(bones_, bone); };
        const bool legs = both("leftUpperLeg") && both("rightUpperLeg"), arms = both("leftUpperArm") && both("rightUpperArm");
        if (both("hips") && (legs || arms)) return {};
        const auto list = [](std::span<const JointData> joints) {
            std::string text;
            for (const JointData& joint : joints) text += (text.empty() ? "" : ", ") + joint.name;
            return text;
        };
        const bool sourceLacks =
            !find(source_.bones(), "hips") || (!find(source_.bones(), "leftUpperLeg") && !find(source_.bones(), "leftUpperArm"));
        return fail(Code::Unsupported, "{}: the {} skeleton has no recognisable hips with arms or legs; its joints are: {}", motion_.name,
                    sourceLacks ? "motion's" : "avatar's", sourceLacks ? list(motion_.joints) : list(target_));
    }

    Vec3f sourceRest(size_t joint) const { return source_.rest()[joint]; }

    /** The child of a joint that has exactly one, such as an end site or a fingertip. */
    static std::optional<size_t> onlyChild(std::span<const JointData> joints, size_t joint) {
        std::optional<size_t> child;
        for (size_t j = joint + 1; j < joints.size(); ++j)
            if (joints[j].parent == int32_t(joint)) {
                if (child) return std::nullopt;
                child = j;
            }
        return child;
    }

    void mapBones() {
        for (const auto& [bone, joint] : bones_)
            if (const auto from = find(source_.bones(), bone)) driven_.push_back({joint, *from, kIdentity, Vec3f(0), std::nullopt});
        // The top of the spine carries the arms. If the target has fewer spine bones, its last one follows the last one of the source.
        if (auto top = topOfSpine(bones_), from = topOfSpine(source_.bones()); top && from)
            if (Driven* d = drivenBy(*top)) d->source = *from;
        std::sort(driven_.begin(), driven_.end(), [](const Driven& a, const Driven& b) { return a.target < b.target; });
        for (const char* side : {"left", "right"})
            for (const LimbBone& limb : kLimbs) alignLimb(side, limb);
        for (const char* side : {"left", "right"}) alignPalm(side);
    }

    static std::optional<size_t> topOfSpine(const BoneMap& bones) {
        for (std::string_view bone : {"upperChest", "chest", "spine"})
            if (auto joint = find(bones, bone)) return joint;
        return std::nullopt;
    }

    Driven* drivenBy(size_t targetJoint) {
        for (Driven& d : driven_)
            if (d.target == targetJoint) return &d;
        return nullptr;
    }
    Driven* drivenBone(const std::string& bone) {
        const auto joint = find(bones_, bone);
        return joint ? drivenBy(*joint) : nullptr;
    }

    void alignLimb(const std::string& side, const LimbBone& limb) {
        Driven* d = drivenBone(side + std::string(limb.bone));
        if (!d) return;
        const Driven* parent = limb.parent.empty() ? nullptr : drivenBone(side + std::string(limb.parent));
        if (parent) d->align = parent->align;
        std::optional<size_t> targetNext, sourceNext;
        if (!limb.next.empty()) {
            targetNext = find(bones_, side + std::string(limb.next));
            sourceNext = find(source_.bones(), side + std::string(limb.next));
        }
        if (!targetNext || !sourceNext) {  // last mapped bone of its chain: needs a tip in both skeletons
            if (limb.bone == "Hand") return;
            targetNext = onlyChild(target_, d->target);
            sourceNext = onlyChild(motion_.joints, d->source);
        }
        if (!targetNext || !sourceNext) return;
        const Vec3f to = target_[*targetNext].restPosition - target_[d->target].restPosition;
        const Vec3f from = sourceRest(*sourceNext) - sourceRest(d->source);
        if (!(glm::length(to) > 1e-5f) || !(glm::length(from) > 1e-5f)) return;
        d->restDirection = glm::normalize(to);
        d->align = glm::normalize(shortestTurn(d->align * d->restDirection, from) * d->align);
        d->sourceNext = sourceNext;
    }

    /** Aligns the roll of a hand about its own direction, by the line from the little finger to the index finger. The forearm takes half of
     *  the roll. */
    void alignPalm(const std::string& side) {
        Driven* hand = drivenBone(side + "Hand");
        const auto across = [&](const BoneMap& bones, auto&& at) -> std::optional<Vec3f> {
            const auto index = find(bones, side + "IndexProximal");
            auto little = find(bones, side + "LittleProximal");
            if (!little) little = find(bones, side + "RingProximal");
            if (!index || !little) return std::nullopt;
            return at(*index) - at(*little);
        };
        if (!hand || !hand->sourceNext) return;
        const auto to = across(bones_, [&](size_t j) { return target_[j].restPosition; });
        const auto from = across(source_.bones(), [&](size_t j) { return sourceRest(j); });
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
        for (const LimbBone& limb : kLimbs)  // fingers inherit the roll of the hand
            if (limb.bone != "Hand" && limb.parent != "" && limb.bone.find("Arm") == std::string_view::npos &&
                limb.bone.find("Leg") == std::string_view::npos)
                alignLimb(side, limb);
    }

    /** Turns the head so that it is level at the median of the frames in which the person walks or runs. Marker sets tell the head's
     * rotation up to a constant of the session: subjects of CMU walk with heads that point 28° up to 28° down. */
    void levelHead() {
        constexpr float kWalkMPerS = 0.5f, kLeastS = 0.5f, kLongestStepS = 0.25f, kUprightCosine = 0.85f, kLargestRad = glm::radians(45.0f);
        const size_t hips = *find(source_.bones(), "hips");
        Driven* head = drivenBone("head");
        const auto chest = topOfSpine(source_.bones());
        if (!head || !chest) return;
        std::vector<Quatf> rotations;
        std::vector<Vec3f> positions;
        std::vector<float> pitch;
        Vec3f before(0);
        float walkedS = 0, beforeS = 0;
        for (size_t k = 0; k < motion_.keyCount(); ++k) {
            if (k > 0 && k + 1 < motion_.keyCount() && motion_.timesS[k] - beforeS < 0.03f) continue;
            source_.at(k, rotations, positions);
            const float stepS = motion_.timesS[k] - beforeS;
            const Vec3f moved = positions[hips] - before;
            if (k > 0 && stepS < kLongestStepS && std::hypot(moved.x, moved.z) * travelScale() > kWalkMPerS * stepS &&
                (rotations[*chest] * Vec3f(0, 1, 0)).y > kUprightCosine) {
                const Vec3f forward = rotations[head->source] * Vec3f(0, 0, 1);
                pitch.push_back(std::asin(std::clamp(forward.y, -1.0f, 1.0f)));
                walkedS += stepS;
            }
            before = positions[hips], beforeS = motion_.timesS[k];
        }
        if (walkedS < kLeastS) return;
        const auto middle = pitch.begin() + std::ptrdiff_t(pitch.size() / 2);
        std::nth_element(pitch.begin(), middle, pitch.end());
        if (std::abs(*middle) < kLargestRad) head->align = glm::angleAxis(*middle, Vec3f(1, 0, 0));
    }

    /** First key to keep. Many BVH files blend from a rest pose into the motion within a few frames, faster than a body can move. (CMU/Daz
     *  clips: 25-48° per frame for five frames at 120 Hz; their fastest real motion is 15°.) */
    size_t firstKey() const {
        constexpr float kStartRadPerS = glm::radians(1800.0f), kStopRadPerS = glm::radians(720.0f), kLongestS = 0.1f;
        std::vector<Quatf> before, after;
        std::vector<Vec3f> positions;
        source_.at(0, before, positions);
        for (const Driven& d : driven_)
            if (angleBetween(before[d.source], kIdentity) > glm::radians(20.0f)) return 0;
        size_t key = 0;
        while (key + 2 < motion_.keyCount() && motion_.timesS[key + 1] <= kLongestS) {
            source_.at(key + 1, after, positions);
            float step = 0;
            for (const Driven& d : driven_) step = std::max(step, angleBetween(before[d.source], after[d.source]));
            const float speed = step / (motion_.timesS[key + 1] - motion_.timesS[key]);
            if (speed < (key == 0 ? kStartRadPerS : kStopRadPerS)) break;
            std::swap(before, after);
            ++key;
        }
        return key;
    }

    void addKey(size_t key, ClipData& clip, std::vector<float>& clearance) {
        source_.at(key, sourceRotations_, sourcePositions_);
        world_.assign(target_.size(), kIdentity);
        positions_.resize(target_.size());
        size_t next = 0;
        for (size_t j = 0; j < target_.size(); ++j) {
            const int32_t parent = target_[j].parent;
            const Quatf above = parent < 0 ? kIdentity : world_[size_t(parent)];
            positions_[j] = parent < 0
                                ? target_[j].restPosition
                                : positions_[size_t(parent)] + above * (target_[j].restPosition - target_[size_t(parent)].restPosition);
            world_[j] = above;
            if (next >= driven_.size() || driven_[next].target != j) continue;
            const Driven& d = driven_[next];
            Quatf turned = glm::normalize(sourceRotations_[d.source] * d.align);
            if (d.sourceNext)  // joints between this bone and the next (twist bones, half bones) may bend too: match the posed direction
                turned = glm::normalize(
                    shortestTurn(turned * d.restDirection, sourcePositions_[*d.sourceNext] - sourcePositions_[d.source]) * turned);
            world_[j] = turned;
            Quatf local = glm::normalize(glm::conjugate(above) * turned);
            std::vector<Quatf>& keys = clip.channels[next].rotations;
            if (!keys.empty() && glm::dot(keys.back(), local) < 0) local = -local;
            keys.push_back(local);
            ++next;
        }
        const size_t hips = *find(bones_, "hips");
        clip.rootTranslations.push_back(sourcePositions_[*find(source_.bones(), "hips")] * travelScale() - positions_[hips]);
        float lowest = 1e30f;
        for (std::string_view bone : {"leftFoot", "rightFoot", "leftToes", "rightToes"})
            if (const auto joint = find(bones_, bone))
                lowest = std::min(lowest, positions_[*joint].y + clip.rootTranslations.back().y - target_[*joint].restPosition.y);
        clearance.push_back(lowest < 1e29f ? lowest : 0.0f);
    }

    /** Ratio of leg lengths, target to source. Without legs: of the heights of the hips above the lowest joint. */
    float travelScale() const {
        if (travelScale_ > 0) return travelScale_;
        const auto legs = [](const BoneMap& bones, auto&& at) {
            float sum = 0;
            for (const std::string side : {"left", "right"}) {
                const auto hip = find(bones, side + "UpperLeg"), knee = find(bones, side + "LowerLeg"), foot = find(bones, side + "Foot");
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
        const auto sourceAt = [&](size_t j) { return sourceRest(j); };
        float a = legs(bones_, targetAt), b = legs(source_.bones(), sourceAt);
        if (!(a > 1e-3f) || !(b > 1e-3f)) {
            a = height(*find(bones_, "hips"), target_.size(), targetAt);
            b = height(*find(source_.bones(), "hips"), motion_.joints.size(), sourceAt);
        }
        travelScale_ = a > 1e-3f && b > 1e-3f ? a / b : 1.0f;
        return travelScale_;
    }

    void place(const RetargetOptions& options, const std::vector<float>& clearance, ClipData& clip) const {
        Vec3f shift(0);
        const Vec3f start = clip.rootTranslations.front();
        if (!options.keepPlace) shift = Vec3f(-start.x, 0, -start.z);
        if (options.groundFeet) {
            std::vector<float> sorted = clearance;  // 1st percentile, so that a single wrong frame does not lift the avatar
            std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 100), sorted.end());
            shift.y = -sorted[sorted.size() / 100];
        }
        for (Vec3f& t : clip.rootTranslations) {
            t += shift;
            if (options.inPlace) t.x = t.z = 0;
        }
    }

    const Motion& motion_;
    UprightSource source_;
    std::span<const JointData> target_;
    BoneMap bones_;
    std::vector<Driven> driven_;
    mutable float travelScale_ = 0;
    std::vector<Quatf> sourceRotations_, world_;
    std::vector<Vec3f> sourcePositions_, positions_;
};

}  // namespace

Result<ClipData> retarget(const Motion& source, std::span<const JointData> target, const RetargetOptions& options) {
    if (auto rig = checkRig(target); !rig)
        return fail(Code::InvalidArgument, "the rig to retarget onto is not valid: {}", rig.error().message);
    if (auto rig = checkRig(source.joints); !rig) return rig.error();
    if (source.keyCount() == 0 || source.rotations.size() != source.keyCount() * source.joints.size())
        return fail(Code::CorruptData, "{}: {} keys of {} joints need {} rotations, there are {}", source.name, source.keyCount(),
                    source.joints.size(), source.keyCount() * source.joints.size(), source.rotations.size());
    for (const Motion::Translation& t : source.translations)
        if (t.joint >= source.joints.size() || t.offsets.size() != source.keyCount())
            return fail(Code::CorruptData, "{}: a translation track does not fit the motion", source.name);
    return Retargeter(source, target).run(options);
}

}  // namespace dpl
