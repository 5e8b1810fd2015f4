// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/retarget.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/rig.h"
#include "sdk/motion/bone_follower.h"
#include "sdk/motion/plant_feet.h"
#include "sdk/motion/standing_rest.h"

namespace dpl {
namespace {

const Quatf kIdentity(1, 0, 0, 0);

float angleBetween(const Quatf& a, const Quatf& b) {
    return 2 * std::acos(std::min(1.0f, std::abs(glm::dot(a, b))));
}

/** World rotations D and positions of the source at every key, turned so that it stands along +Y and faces +Z. D is relative to a standing
 *  rest pose. */
class UprightSource {
public:
    explicit UprightSource(const Motion& motion) : motion_(motion), rest_(standingRest(motion)) {}

    const BoneMap& bones() const { return rest_.bones; }
    std::span<const Vec3f> rest() const { return rest_.at; }
    const std::string& note() const { return rest_.note; }
    void at(size_t key, std::vector<Quatf>& rotations, std::vector<Vec3f>& positions) const {
        motionAt(motion_, key, rotations, positions);
        for (size_t j = 0; j < rotations.size(); ++j) {
            rotations[j] = rest_.upright * rotations[j] * rest_.inverse[j] * glm::conjugate(rest_.upright);
            positions[j] = rest_.upright * positions[j];
        }
    }

private:
    const Motion& motion_;
    StandingRest rest_;
};

class Retargeter {
public:
    Retargeter(const Motion& motion, std::span<const JointData> target)
        : motion_(motion), source_(motion), target_(target), follower_(motion.joints, source_.bones(), source_.rest(), target) {}

    Result<ClipData> run(const RetargetOptions& options) {
        DPL_RETURN_IF_ERROR(checkCommonBones(motion_.name, motion_.joints, source_.bones(), target_, follower_.targetBones()));
        if (options.notes) noteWhatIsLacking(*options.notes);
        travelScale_ = follower_.travelScale();
        if (options.levelHead) levelHead();
        const size_t first = options.keepLeadIn ? 0 : firstKey();
        ClipData clip;
        clip.name = motion_.name;
        for (size_t k = first; k < motion_.keyCount(); ++k) clip.timesS.push_back(motion_.timesS[k] - motion_.timesS[first]);
        for (const BoneFollower::Driven& d : follower_.driven()) clip.channels.push_back({uint32_t(d.target), {}});
        for (ClipChannel& channel : clip.channels) channel.rotations.reserve(clip.timesS.size());
        std::vector<float> clearance;
        for (size_t k = first; k < motion_.keyCount(); ++k) addKey(k, clip, clearance);
        place(options, clearance, clip);
        if (options.plantFeet) plantFeet(target_, clip);
        if (options.body) pushArmsOut(*options.body, clip);
        for (const ClipChannel& channel : clip.channels)
            for (const Quatf& q : channel.rotations)
                if (!std::isfinite(q.w + q.x + q.y + q.z))
                    return fail(Code::CorruptData, "{}: the motion of '{}' is not finite", motion_.name, target_[channel.joint].name);
        for (const Vec3f& t : clip.rootTranslations)
            if (!std::isfinite(t.x + t.y + t.z)) return fail(Code::CorruptData, "{}: the travel of the hips is not finite", motion_.name);
        return clip;
    }

private:
    /** Limbs and head that the target has and nothing drives, so that they keep their rest pose. */
    void noteWhatIsLacking(std::vector<std::string>& notes) {
        if (!source_.note().empty()) notes.push_back(source_.note());
        std::string lacking;
        const auto look = [&](const std::string& bone) {
            if (findBone(follower_.targetBones(), bone) && !follower_.drivenBone(bone)) lacking += (lacking.empty() ? "" : ", ") + bone;
        };
        look("head");
        for (const std::string side : {"left", "right"})
            for (const char* bone : {"UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot"}) look(side + bone);
        if (!lacking.empty())
            notes.push_back("the motion does not drive " + lacking +
                            ", which go stiffly with the bone above; name or map these joints in it");
    }

    /** Turns the head so that it is level at the median of the frames in which the person walks or runs. Marker sets tell the head's
     * rotation up to a constant of the session: subjects of CMU walk with heads that point 28° up to 28° down. */
    void levelHead() {
        constexpr float kWalkMPerS = 0.5f, kLeastS = 0.5f, kLongestStepS = 0.25f, kUprightCosine = 0.85f, kLargestRad = glm::radians(45.0f);
        const size_t hips = *findBone(source_.bones(), "hips");
        BoneFollower::Driven* head = follower_.drivenBone("head");
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
            if (k > 0 && stepS < kLongestStepS && std::hypot(moved.x, moved.z) * travelScale_ > kWalkMPerS * stepS &&
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
        for (const BoneFollower::Driven& d : follower_.driven())
            if (angleBetween(before[d.source], kIdentity) > glm::radians(20.0f)) return 0;
        size_t key = 0;
        while (key + 2 < motion_.keyCount() && motion_.timesS[key + 1] <= kLongestS) {
            source_.at(key + 1, after, positions);
            float step = 0;
            for (const BoneFollower::Driven& d : follower_.driven()) step = std::max(step, angleBetween(before[d.source], after[d.source]));
            const float speed = step / (motion_.timesS[key + 1] - motion_.timesS[key]);
            if (speed < (key == 0 ? kStartRadPerS : kStopRadPerS)) break;
            std::swap(before, after);
            ++key;
        }
        return key;
    }

    void addKey(size_t key, ClipData& clip, std::vector<float>& clearance) {
        source_.at(key, sourceRotations_, sourcePositions_);
        local_.assign(target_.size(), kIdentity);
        follower_.pose(sourceRotations_, sourcePositions_, {}, local_);
        for (size_t i = 0; i < clip.channels.size(); ++i) {
            std::vector<Quatf>& keys = clip.channels[i].rotations;
            const Quatf& local = local_[clip.channels[i].joint];
            keys.push_back(!keys.empty() && glm::dot(keys.back(), local) < 0 ? -local : local);
        }
        const std::span<const Vec3f> positions = follower_.positions();
        const BoneMap& bones = follower_.targetBones();
        const size_t hips = *findBone(bones, "hips");
        clip.rootTranslations.push_back(sourcePositions_[*findBone(source_.bones(), "hips")] * travelScale_ - positions[hips]);
        float lowest = 1e30f;
        for (std::string_view bone : {"leftFoot", "rightFoot", "leftToes", "rightToes"})
            if (const auto joint = findBone(bones, bone))
                lowest = std::min(lowest, positions[*joint].y + clip.rootTranslations.back().y - target_[*joint].restPosition.y);
        clearance.push_back(lowest < 1e29f ? lowest : 0.0f);
    }

    /** Elbows and wrists move by the largest push within kPushS of a key, averaged over the same time: they start early and stay smooth. */
    void pushArmsOut(const BodyShape& body, ClipData& clip) const {
        constexpr float kPushS = 0.25f;
        ArmGuard arms(body, target_);
        const size_t count = clip.timesS.size();
        const auto poseAt = [&](size_t k) {
            Pose pose = Pose::rest(target_.size());
            for (const ClipChannel& channel : clip.channels) pose.localRotations[channel.joint] = channel.rotations[k];
            if (!clip.rootTranslations.empty()) pose.rootTranslation = clip.rootTranslations[k];
            return pose;
        };
        std::vector<ArmGuard::Pushes> needed(count), largest(count);
        for (size_t k = 0; k < count; ++k) needed[k] = arms.pushes(poseAt(k));
        const auto within = [&](size_t k, auto&& visit) {
            for (size_t n = k; n < count && clip.timesS[n] - clip.timesS[k] <= kPushS; ++n) visit(n);
            for (size_t n = k; n > 0 && clip.timesS[k] - clip.timesS[n - 1] <= kPushS; --n) visit(n - 1);
        };
        const auto enlarge = [](Vec3f& push, const Vec3f& other) {
            if (glm::length(other) > glm::length(push)) push = other;
        };
        for (size_t side = 0; side < 2; ++side)
            for (size_t k = 0; k < count; ++k) {
                ArmGuard::Push& most = largest[k][side];
                within(k, [&](size_t n) { enlarge(most.elbow, needed[n][side].elbow), enlarge(most.wrist, needed[n][side].wrist); });
            }
        for (size_t k = 0; k < count; ++k) {
            ArmGuard::Pushes mean{};
            float visited = 0;
            within(k, [&](size_t n) {
                for (size_t side = 0; side < 2; ++side)
                    mean[side].elbow += largest[n][side].elbow, mean[side].wrist += largest[n][side].wrist;
                ++visited;
            });
            for (ArmGuard::Push& push : mean) push.elbow /= visited, push.wrist /= visited;
            if (mean[0].none() && mean[1].none()) continue;
            Pose pose = poseAt(k);
            arms.push(mean, pose);
            for (ClipChannel& channel : clip.channels) {
                const Quatf& q = pose.localRotations[channel.joint];
                channel.rotations[k] = k > 0 && glm::dot(channel.rotations[k - 1], q) < 0 ? -q : q;
            }
        }
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
    BoneFollower follower_;
    float travelScale_ = 1;
    std::vector<Quatf> sourceRotations_, local_;
    std::vector<Vec3f> sourcePositions_;
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
