// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/moves.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/humanoid.h"
#include "sdk/core/result.h"

namespace dpl {
namespace {

// How far a move goes at least, in degrees: about half of what people do when they are asked for it.
constexpr float kRaisedDeg = 110, kBentDeg = 60, kLiftedDeg = 45, kBowedDeg = 35, kTwistedDeg = 12, kHeadDeg = 20, kStepDeg = 25,
                kTurnedDeg = 60;

/** Largest and smallest value over the poses. */
struct Range {
    float least = 1e9f, most = -1e9f;
    void add(float value) { least = std::min(least, value), most = std::max(most, value); }
    /** Whether it goes to both sides of zero by this much. */
    bool bothWays(float by) const { return least <= -by && most >= by; }
};

/** Angles of a body, in degrees. Axes are those at rest: x left, y up, z front. */
class Angles {
public:
    explicit Angles(std::span<const JointData> joints) : joints_(joints), bones_(bonesOf(joints)) {
        hips_ = find("hips"), chest_ = topOfSpine(bones_), head_ = find("head");
        for (size_t side = 0; side < 2; ++side) {
            const std::string name = side == 0 ? "left" : "right";
            arm_[side] = limb(name + "UpperArm", name + "LowerArm", name + "Hand");
            leg_[side] = limb(name + "UpperLeg", name + "LowerLeg", name + "Foot");
        }
    }
    bool trunk() const { return hips_ && chest_; }
    bool headKnown() const { return chest_ && head_; }
    bool arms() const { return chest_ && arm_[0].known && arm_[1].known; }
    bool legs() const { return hips_ && leg_[0].known && leg_[1].known; }

    void pose(const Pose& pose) { jointTransforms(joints_, pose, worldFromRest_); }
    /** Of the upper arm from straight down, in the frame of the chest. */
    float raised(size_t side) const { return degrees(std::acos(std::clamp(-upper(arm_[side], *chest_).y, -1.0f, 1.0f))); }
    float bentElbow(size_t side) const {
        return degrees(std::acos(std::clamp(glm::dot(upper(arm_[side], *chest_), lower(arm_[side], *chest_)), -1.0f, 1.0f)));
    }
    /** Of the thigh forwards from straight down, in the frame of the hips. */
    float lifted(size_t side) const {
        const Vec3f d = upper(leg_[side], *hips_);
        return degrees(std::atan2(d.z, -d.y));
    }
    float bowed() const { return degrees(std::asin(std::clamp(axis(*chest_, 1, *hips_).z, -1.0f, 1.0f))); }
    float twisted() const { return yaw(*chest_, *hips_); }
    float headTurned() const { return yaw(*head_, *chest_); }
    Vec3f front() const { return worldFromRest_[*hips_][2]; }
    Vec3f up() const { return worldFromRest_[*hips_][1]; }

private:
    struct Limb {
        size_t top = 0, middle = 0, end = 0;
        bool known = false;
    };
    std::span<const JointData> joints_;
    BoneMap bones_;
    std::optional<size_t> hips_, chest_, head_;
    Limb arm_[2], leg_[2];
    std::vector<Mat3x4f> worldFromRest_;

    static float degrees(float radians) { return glm::degrees(radians); }
    std::optional<size_t> find(std::string_view bone) const { return findBone(bones_, bone); }
    Limb limb(std::string_view top, std::string_view middle, std::string_view end) const {
        const auto a = find(top), b = find(middle), c = find(end);
        if (!a || !b || !c) return {};
        return {*a, *b, *c, true};
    }
    Mat3f turnOf(size_t joint) const { return Mat3f(worldFromRest_[joint][0], worldFromRest_[joint][1], worldFromRest_[joint][2]); }
    Vec3f placeOf(size_t joint) const { return worldFromRest_[joint] * Vec4f(joints_[joint].restPosition, 1); }
    /** Direction from one joint to the next in the frame of another, unit; straight down where the joints lie at one place. */
    Vec3f direction(size_t from, size_t to, size_t frame) const {
        const Vec3f d = glm::transpose(turnOf(frame)) * (placeOf(to) - placeOf(from));
        return glm::length(d) > 1e-6f ? glm::normalize(d) : Vec3f(0, -1, 0);
    }
    Vec3f upper(const Limb& l, size_t frame) const { return direction(l.top, l.middle, frame); }
    Vec3f lower(const Limb& l, size_t frame) const { return direction(l.middle, l.end, frame); }
    /** An axis of a joint in the frame of another. */
    Vec3f axis(size_t joint, int which, size_t frame) const { return glm::transpose(turnOf(frame)) * turnOf(joint)[which]; }
    float yaw(size_t joint, size_t frame) const {
        const Vec3f ahead = axis(joint, 2, frame);
        return degrees(std::atan2(ahead.x, ahead.z));
    }
};

/** The widest arc that the hips' front passes, in degrees: 360 minus the largest gap between headings. fronts and ups: one a pose. */
float headingArc(std::span<const Vec3f> fronts, std::span<const Vec3f> ups) {
    Vec3f up(0);
    for (const Vec3f& u : ups) up += u;
    if (!(glm::length(up) > 1e-3f)) return 0;
    up = glm::normalize(up);
    const Vec3f some = std::abs(up.x) < 0.9f ? Vec3f(1, 0, 0) : Vec3f(0, 0, 1);
    const Vec3f x = glm::normalize(glm::cross(up, some)), y = glm::cross(up, x);
    std::vector<float> headings;
    for (const Vec3f& f : fronts) headings.push_back(glm::degrees(std::atan2(glm::dot(f, y), glm::dot(f, x))));
    std::sort(headings.begin(), headings.end());
    float gap = headings.front() + 360 - headings.back();
    for (size_t i = 1; i < headings.size(); ++i) gap = std::max(gap, headings[i] - headings[i - 1]);
    return 360 - gap;
}

/** "a, b and c". */
std::string listed(std::span<const std::string_view> parts) {
    std::string text;
    for (size_t i = 0; i < parts.size(); ++i) {
        if (i > 0) text += i + 1 == parts.size() ? " and " : ", ";
        text += parts[i];
    }
    return text;
}

}  // namespace

std::vector<std::string_view> missingMoves(std::span<const JointData> joints, std::span<const Pose> moving) {
    Angles body(joints);
    Range raised[2], bent[2], lifted[2], bowed, step, twisted, head;
    std::vector<Vec3f> fronts, ups;
    for (const Pose& pose : moving) {
        body.pose(pose);
        if (body.arms())
            for (size_t side = 0; side < 2; ++side) raised[side].add(body.raised(side)), bent[side].add(body.bentElbow(side));
        if (body.legs()) {
            for (size_t side = 0; side < 2; ++side) lifted[side].add(body.lifted(side));
            step.add(body.lifted(0) - body.lifted(1));
            bowed.add(std::min(body.lifted(0), body.lifted(1)));  // who bows turns the hips, so both thighs point forwards in their frame
        }
        if (body.trunk()) {
            bowed.add(body.bowed()), twisted.add(body.twisted());
            fronts.push_back(body.front()), ups.push_back(body.up());
        }
        if (body.headKnown()) head.add(body.headTurned());
    }
    std::vector<std::string_view> missing;
    const auto need = [&](bool known, bool shown, std::string_view words) {
        if (known && !shown) missing.push_back(words);
    };
    need(body.arms(), raised[0].most >= kRaisedDeg && raised[1].most >= kRaisedDeg, "raise both arms to the side and up");
    need(body.arms(), bent[0].most >= kBentDeg && bent[1].most >= kBentDeg, "bend both elbows");
    need(body.legs(), lifted[0].most >= kLiftedDeg && lifted[1].most >= kLiftedDeg, "lift one knee and then the other");
    need(body.trunk() && body.legs(), bowed.most >= kBowedDeg, "bow");
    need(body.trunk(), twisted.bothWays(kTwistedDeg), "twist to both sides");
    need(body.headKnown(), head.bothWays(kHeadDeg), "turn the head to both sides");
    need(body.legs(), step.bothWays(kStepDeg), "walk on the spot with long steps and swinging arms");
    need(body.trunk(), !fronts.empty() && headingArc(fronts, ups) >= kTurnedDeg, "turn quickly on the spot to both sides");
    return missing;
}

std::optional<Shot> movesToFilm(std::span<const JointData> joints, std::span<const Pose> moving) {
    const std::vector<std::string_view> missing = missingMoves(joints, moving);
    if (missing.empty()) return std::nullopt;
    if (moving.empty())
        return Shot{"moves",
                    formatText("Film the moves while you walk round: {}. Without them clothes look stiff in motion", listed(missing)), 0};
    return Shot{"moves", formatText("Film these moves too: {}. Clothes learn only from moves that are filmed", listed(missing)), 0};
}

}  // namespace dpl
