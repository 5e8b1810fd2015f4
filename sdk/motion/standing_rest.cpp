// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/standing_rest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sdk/motion/bone_follower.h"
#include "sdk/motion/limb.h"

namespace dpl {
namespace {

constexpr size_t kMostKeys = 2000;   // of a long clip that are looked at, evenly spaced
constexpr float kNearlyBest = 0.1f;  // of the score: frames that stand about as well as the best
constexpr float kLiesToo = 0.3f;     // of the score: an axis along which the person stands nearly as well at one time
constexpr float kLeastLength = 1e-4f;

Vec3f unitOr(const Vec3f& v, const Vec3f& otherwise) {
    const float length = glm::length(v);
    return length > kLeastLength ? v / length : otherwise;
}

class BestStanding {
public:
    explicit BestStanding(const Motion& motion, const BoneMap& bones) : motion_(motion), bones_(bones) {
        step_ = std::max<size_t>(1, motion.keyCount() / kMostKeys);
    }

    /** Finds the key and the axis along which it stands. False: the bones do not tell. */
    bool find() {
        const auto legs = [&](const char* bone) { return boneOf("left", bone) && boneOf("right", bone); };
        if (!findBone(bones_, "hips") || !trunkTop({})) return false;
        if (!legs("UpperLeg") || !legs("LowerLeg")) return false;
        struct Axis {
            float best = -2, sum = 0;
            size_t key = 0;
        };
        std::array<Axis, 6> axes;
        std::vector<Quatf> rotations;
        for (size_t k = 0; k < motion_.keyCount(); k += step_) {
            motionAt(motion_, k, rotations, at_);
            for (size_t a = 0; a < axes.size(); ++a) {
                const float score = scoreOf(axisOf(a));
                if (score > axes[a].best + 1e-4f) axes[a].best = score, axes[a].key = k;
                axes[a].sum += score;
            }
        }
        const float most = std::max_element(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.best < b.best; })->best;
        float usual = -1e30f;
        for (const size_t a : {1, 2, 0, 4, 5, 3}) {  // +y and +z first: people lie too, but files have these up
            if (axes[a].best < most - kLiesToo || axes[a].sum <= usual) continue;
            usual = axes[a].sum, score_ = axes[a].best, key_ = axes[a].key, up_ = axisOf(a);
        }
        return score_ > 0;
    }
    static Vec3f axisOf(size_t a) {
        Vec3f axis(0);
        axis[int(a % 3)] = a < 3 ? 1.0f : -1.0f;
        return axis;
    }
    size_t key() const { return key_; }
    size_t step() const { return step_; }
    const Vec3f& up() const { return up_; }
    float score() const { return score_; }

    /** 2: trunk and legs stand straight along `up`. */
    float scoreOf(const Vec3f& up) const {
        float legs = 0;
        int count = 0;
        for (const char* side : {"left", "right"})
            for (const auto& [from, to] : {std::pair("UpperLeg", "LowerLeg"), {"LowerLeg", "Foot"}}) {
                const auto a = boneOf(side, from), b = boneOf(side, to);
                if (a && b) legs += glm::dot(unitOr(at_[*a] - at_[*b], Vec3f(0)), up), ++count;
            }
        const Vec3f trunk = trunkTop(at_).value_or(Vec3f(0)) - at_[*findBone(bones_, "hips")];
        return glm::dot(unitOr(trunk, Vec3f(0)), up) + (count > 0 ? legs / float(count) : 0.0f);
    }
    void show(size_t key, std::vector<Quatf>& rotations) { motionAt(motion_, key, rotations, at_); }
    const std::vector<Vec3f>& at() const { return at_; }

private:
    std::optional<size_t> boneOf(const std::string& side, const char* bone) const { return findBone(bones_, side + bone); }
    /** Middle of the shoulders, or the top of the spine. Without positions: whether there is one. */
    std::optional<Vec3f> trunkTop(std::span<const Vec3f> at) const {
        const auto left = findBone(bones_, "leftUpperArm"), right = findBone(bones_, "rightUpperArm"), top = topOfSpine(bones_);
        if (left && right) return at.empty() ? Vec3f(0) : 0.5f * (at[*left] + at[*right]);
        if (top) return at.empty() ? Vec3f(0) : at[*top];
        return std::nullopt;
    }

    const Motion& motion_;
    const BoneMap& bones_;
    std::vector<Vec3f> at_;
    size_t step_ = 1, key_ = 0;
    Vec3f up_{0, 1, 0};
    float score_ = 0;
};

/** World rotations since a T-pose of the joints of one frame, in upright axes, from their positions. */
class Straightener {
public:
    Straightener(const Motion& motion, const BoneMap& bones, std::span<const Vec3f> at) : motion_(motion), bones_(bones), at_(at) {}

    std::vector<Quatf> run() {
        turns_.assign(motion_.joints.size(), std::nullopt);
        const auto hips = trunkFrame("UpperLeg"), chest = trunkFrame("UpperArm");
        const Quatf pelvis = hips.value_or(chest.value_or(kNoTurn)), ribs = chest.value_or(pelvis);
        set("hips", pelvis);
        set("spine", glm::slerp(pelvis, ribs, 0.5f));
        for (const char* bone : {"chest", "upperChest", "neck", "head", "leftShoulder", "rightShoulder"}) set(bone, ribs);
        if (const auto top = topOfSpine(bones_)) turns_[*top] = ribs;
        for (const float sign : {1.0f, -1.0f}) {
            const std::string side = sign > 0 ? "left" : "right";
            arm(side, sign, ribs);
            leg(side, pelvis);
        }
        std::vector<Quatf> out;
        for (size_t j = 0; j < turns_.size(); ++j) {
            const int32_t parent = motion_.joints[j].parent;
            out.push_back(turns_[j] ? *turns_[j] : parent < 0 ? pelvis : out[size_t(parent)]);
        }
        return out;
    }

private:
    std::optional<Vec3f> place(const std::string& bone) const {
        const auto joint = findBone(bones_, bone);
        return joint ? std::optional(at_[*joint]) : std::nullopt;
    }
    void set(const std::string& bone, const Quatf& turn) {
        if (const auto joint = findBone(bones_, bone)) turns_[*joint] = glm::normalize(turn);
    }
    /** Of the pelvis or the chest: across by its pair of joints, up by hips and shoulders. */
    std::optional<Quatf> trunkFrame(const std::string& pair) const {
        const auto left = place("left" + pair), right = place("right" + pair), hips = place("hips");
        if (!left || !right || !hips) return std::nullopt;
        // Shoulders lie behind the hips at rest by some 5°, neck and head by half as much.
        auto top = place("neck"), other = place("head");
        if (!top || !other) top = place("leftUpperArm"), other = place("rightUpperArm");
        if (top && other) top = 0.5f * (*top + *other);
        if (const auto spine = topOfSpine(bones_); !top && spine) top = at_[*spine];
        const Vec3f across = *left - *right, up = top ? *top - *hips : Vec3f(0, 1, 0);
        if (!(glm::length(across) > kLeastLength) || !(glm::length(up) > kLeastLength)) return std::nullopt;
        return frameOf(across, up);
    }

    void arm(const std::string& side, float sign, const Quatf& ribs) {
        const auto shoulder = place(side + "UpperArm"), elbow = place(side + "LowerArm"), wrist = place(side + "Hand");
        if (!shoulder || !elbow || !wrist) return;
        const Vec3f upper = *elbow - *shoulder, lower = *wrist - *elbow, rest(sign, 0, 0);
        if (!(glm::length(upper) > kLeastLength) || !(glm::length(lower) > kLeastLength)) return;
        const auto [first, second] = hingedLimb(ribs, rest, Vec3f(0, -sign, 0), upper, lower);
        set(side + "UpperArm", first), set(side + "LowerArm", second);
        Quatf hand = second;
        const auto middle = place(side + "MiddleProximal"), index = place(side + "IndexProximal");
        auto little = place(side + "LittleProximal");
        if (!little) little = place(side + "RingProximal");
        if (middle && index && little)
            hand = turnOf(rest, Vec3f(0, 0, 1), *middle - *wrist, *index - *little);
        else if (middle)
            hand = shortestTurn(second * rest, *middle - *wrist) * second;
        set(side + "Hand", hand);
        for (const char* finger : {"Thumb", "Index", "Middle", "Ring", "Little"}) bendFinger(side + finger, rest, hand);
    }
    /** Fingers are straight at rest; a thumb keeps its place in the hand. */
    void bendFinger(const std::string& finger, const Vec3f& rest, const Quatf& hand) {
        if (finger.ends_with("Thumb")) return;
        const std::string bones[] = {finger + "Proximal", finger + "Intermediate", finger + "Distal"};
        Quatf turn = hand;
        for (size_t i = 0; i < 3; ++i) {
            const auto from = place(bones[i]), to = i < 2 ? place(bones[i + 1]) : std::nullopt;
            if (from && to && glm::length(*to - *from) > kLeastLength) turn = shortestTurn(turn * rest, *to - *from) * turn;
            set(bones[i], turn);
        }
    }

    void leg(const std::string& side, const Quatf& pelvis) {
        const auto hip = place(side + "UpperLeg"), knee = place(side + "LowerLeg"), ankle = place(side + "Foot"),
                   toes = place(side + "Toes");
        if (!hip || !knee || !ankle) return;
        const Vec3f upper = *knee - *hip, lower = *ankle - *knee;
        if (!(glm::length(upper) > kLeastLength) || !(glm::length(lower) > kLeastLength)) return;
        const auto [first, second] = hingedLimb(pelvis, Vec3f(0, -1, 0), Vec3f(1, 0, 0), upper, lower);
        set(side + "UpperLeg", first), set(side + "LowerLeg", second);
        Vec3f ahead = toes ? *toes - *ankle : second * Vec3f(0, 0, 1);  // soles are flat where a person stands
        ahead.y = 0;
        if (!(glm::length(ahead) > kLeastLength)) return;
        const Quatf foot = glm::angleAxis(std::atan2(ahead.x, ahead.z), Vec3f(0, 1, 0));
        set(side + "Foot", foot), set(side + "Toes", foot);
    }

    const Motion& motion_;
    const BoneMap& bones_;
    std::span<const Vec3f> at_;
    std::vector<std::optional<Quatf>> turns_;
};

/** The mean of rotations that lie near each other. */
class MeanTurn {
public:
    void add(const Quatf& q) { sum_ = glm::dot(sum_, q) < 0 ? sum_ - q : sum_ + q; }
    Quatf mean() const { return glm::length(sum_) > 1e-3f ? glm::normalize(sum_) : kNoTurn; }

private:
    Quatf sum_{0, 0, 0, 0};
};

/** Replaces what one frame tells of neck and head, which may look anywhere, by the mean of the frames that stand about as well. */
void straightenHead(const Motion& motion, BestStanding& best, StandingRest& rest) {
    const auto chest = topOfSpine(rest.bones);
    if (!chest) return;
    for (const char* bone : {"neck", "head"}) {
        const auto joint = findBone(rest.bones, bone);
        if (!joint) continue;
        MeanTurn mean;
        std::vector<Quatf> rotations;
        for (size_t k = 0; k < motion.keyCount(); k += best.step()) {
            best.show(k, rotations);
            if (best.scoreOf(best.up()) >= best.score() - kNearlyBest) mean.add(glm::conjugate(rotations[*chest]) * rotations[*joint]);
        }
        rest.inverse[*joint] = glm::normalize(glm::conjugate(mean.mean()) * rest.inverse[*chest]);
    }
}

}  // namespace

StandingRest standingRest(const Motion& motion) {
    StandingRest out;
    out.bones = bonesOf(motion.joints);
    for (const JointData& joint : motion.joints) out.at.push_back(joint.restPosition);
    out.inverse.assign(out.at.size(), kNoTurn);
    if (const auto upright = uprightFrom(out.bones, out.at); upright || motion.keyCount() == 0) {
        out.upright = upright.value_or(kNoTurn);
        for (Vec3f& p : out.at) p = out.upright * p;
        return out;
    }
    std::vector<Quatf> rotations;
    BestStanding best(motion, out.bones);
    if (!best.find()) {
        motionAt(motion, 0, rotations, out.at);
        for (size_t j = 0; j < out.at.size(); ++j) out.inverse[j] = glm::conjugate(rotations[j]);
        out.upright = uprightFrom(out.bones, out.at).value_or(kNoTurn);
        for (Vec3f& p : out.at) p = out.upright * p;
        out.note = "its rest pose does not stand; the first frame is taken as one";
        return out;
    }
    best.show(best.key(), rotations);
    out.bones = bonesOf(motion.joints, best.at());  // a pose that stands tells left and right where names do not
    out.upright = shortestTurn(best.up(), Vec3f(0, 1, 0));
    std::vector<Vec3f> at;
    for (const Vec3f& p : best.at()) at.push_back(out.upright * p);
    const std::vector<Quatf> turns = Straightener(motion, out.bones, at).run();
    out.at = at;
    for (size_t j = 0; j < at.size(); ++j) {
        const int32_t parent = motion.joints[j].parent;
        out.inverse[j] = glm::normalize(glm::conjugate(out.upright * rotations[j]) * turns[j] * out.upright);
        if (parent >= 0) out.at[j] = out.at[size_t(parent)] + glm::conjugate(turns[size_t(parent)]) * (at[j] - at[size_t(parent)]);
    }
    straightenHead(motion, best, out);
    out.note =
        formatText("its rest pose does not stand; one was made from the frame at {} s, which stands best", motion.timesS[best.key()]);
    return out;
}

}  // namespace dpl
