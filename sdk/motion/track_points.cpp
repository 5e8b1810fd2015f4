// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/track_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "sdk/avatar/humanoid.h"
#include "sdk/motion/limb.h"

namespace dpl {
namespace {

enum Point : size_t {
    kNose = 0,
    kEye = 2,
    kEar = 7,
    kShoulder = 11,
    kElbow = 13,
    kWristPoint = 15,
    kPinky = 17,
    kIndex = 19,
    kHip = 23,
    kKnee = 25,
    kAnkle = 27,
    kHeel = 29,
    kFootIndex = 31,
};  // of the left side; the right one follows, but eyes are three apart
constexpr size_t kRightEye = 5;

constexpr float kLeastM = 0.01f;  // between two points that shall tell a direction

size_t boneIndex(std::string_view bone) {
    const auto names = humanoidBoneNames();
    return size_t(std::find(names.begin(), names.end(), bone) - names.begin());
}

struct Side {
    size_t shoulder, upperArm, lowerArm, hand, upperLeg, lowerLeg, foot, toes;
};

struct Bones {
    size_t hips = boneIndex("hips"), spine = boneIndex("spine"), chest = boneIndex("chest"), upperChest = boneIndex("upperChest"),
           neck = boneIndex("neck"), head = boneIndex("head");
    std::array<Side, 2> sides{side("left"), side("right")};

    static Side side(const std::string& s) {
        return {boneIndex(s + "Shoulder"), boneIndex(s + "UpperArm"), boneIndex(s + "LowerArm"), boneIndex(s + "Hand"),
                boneIndex(s + "UpperLeg"), boneIndex(s + "LowerLeg"), boneIndex(s + "Foot"),     boneIndex(s + "Toes")};
    }
};

/** The part of a rotation that turns about a unit axis. */
Quatf twistAbout(const Quatf& q, const Vec3f& axis) {
    const float along = glm::dot(Vec3f(q.x, q.y, q.z), axis);
    const Quatf twist(q.w, axis.x * along, axis.y * along, axis.z * along);
    return glm::length(twist) > 1e-6f ? glm::normalize(twist) : Quatf(1, 0, 0, 0);
}

class Solver {
public:
    Solver(std::span<const Vec3f> points, std::span<const uint8_t> tracked, PointBones& out) : at_(points), tracked_(tracked), out_(out) {}

    void run() {
        static const Bones bones;
        const size_t count = humanoidBoneNames().size();
        out_.rotations.assign(count, Quatf(1, 0, 0, 0));
        out_.tracked.assign(count, 0);
        out_.swapped = false;
        if (!has({kShoulder, kShoulder + 1})) return;
        const Vec3f shouldersLeft = at_[kShoulder] - at_[kShoulder + 1];
        Vec3f up(0, 1, 0), hipsLeft = shouldersLeft;
        if (has({kHip, kHip + 1})) {
            up = 0.5f * (at_[kShoulder] + at_[kShoulder + 1] - at_[kHip] - at_[kHip + 1]);
            hipsLeft = at_[kHip] - at_[kHip + 1];
        } else {  // someone at a desk: sits upright
            hipsLeft.y = 0;
        }
        if (!(glm::length(up) > kLeastM) || !(glm::length(hipsLeft) > kLeastM) || !(glm::length(shouldersLeft) > kLeastM)) return;
        const Quatf hips = frameOf(hipsLeft, up), chest = frameOf(shouldersLeft, up);
        set(bones.hips, hips);
        set(bones.spine, glm::slerp(hips, chest, 0.5f));
        set(bones.chest, chest), set(bones.upperChest, chest);
        findHead(chest, bones);
        out_.swapped = isSwapped(hips, chest, bones);
        for (size_t s = 0; s < 2; ++s) {
            const Side& side = bones.sides[s];
            set(side.shoulder, chest);
            arm(s, side, chest);
            leg(s, side, hips);
        }
    }

private:
    bool has(std::initializer_list<size_t> points) const {
        return std::all_of(points.begin(), points.end(), [&](size_t p) { return tracked_[p] != 0; });
    }
    void set(size_t bone, const Quatf& rotation) {
        out_.rotations[bone] = rotation;
        out_.tracked[bone] = 1;
    }

    /** Ear holes and lower rims of the eyes lie level at rest (the Frankfort plane). A rim lies about a quarter of the way from the eye to
     * the tip of the nose. */
    void findHead(const Quatf& chest, const Bones& bones) {
        if (!has({kNose, kEye, kRightEye, kEar, kEar + 1})) return;
        const Vec3f ears = 0.5f * (at_[kEar] + at_[kEar + 1]), eyes = 0.5f * (at_[kEye] + at_[kRightEye]);
        const Vec3f ahead = 0.75f * eyes + 0.25f * at_[kNose] - ears, left = at_[kEar] - at_[kEar + 1];
        if (!(glm::length(ahead) > kLeastM) || !(glm::length(left) > kLeastM)) return;
        const Quatf head = turnOf(Vec3f(0, 0, 1), Vec3f(1, 0, 0), ahead, left);
        set(bones.head, head);
        set(bones.neck, glm::slerp(chest, head, 0.5f));
    }

    bool isSwapped(const Quatf& hips, const Quatf& chest, const Bones& bones) const {
        if (glm::dot(hips * Vec3f(1, 0, 0), chest * Vec3f(1, 0, 0)) < -0.5f) return true;
        const Vec3f ahead = chest * Vec3f(0, 0, 1);
        // Ears are named with the sides, so a face turns round with them; the nose does not.
        const Vec3f ears = 0.5f * (at_[kEar] + at_[kEar + 1]);
        const bool faceBehind = out_.tracked[bones.head] && glm::dot(glm::normalize(at_[kNose] - ears), ahead) < -0.3f;
        float feet = 0;
        int known = 0;
        for (size_t s = 0; s < 2; ++s)
            if (has({kHeel + s, kFootIndex + s})) feet += glm::dot(at_[kFootIndex + s] - at_[kHeel + s], ahead), ++known;
        return faceBehind && (known == 0 || feet < 0);
    }

    void arm(size_t s, const Side& side, const Quatf& chest) {
        if (!has({kShoulder + s, kElbow + s, kWristPoint + s})) return;
        const Vec3f upper = at_[kElbow + s] - at_[kShoulder + s], lower = at_[kWristPoint + s] - at_[kElbow + s];
        if (!(glm::length(upper) > kLeastM) || !(glm::length(lower) > kLeastM)) return;
        const float sign = s == 0 ? 1.0f : -1.0f;
        const Vec3f rest(sign, 0, 0), hinge(0, -sign, 0);  // a forearm bends ahead
        auto [first, second] = hingedLimb(chest, rest, hinge, upper, lower);
        if (has({kPinky + s, kIndex + s})) {
            const Vec3f ahead = 0.5f * (at_[kPinky + s] + at_[kIndex + s]) - at_[kWristPoint + s],
                        across = at_[kIndex + s] - at_[kPinky + s];
            if (glm::length(ahead) > kLeastM && glm::length(glm::cross(glm::normalize(ahead), across)) > kLeastM) {
                const Quatf hand = turnOf(rest, Vec3f(0, 0, 1), ahead, across);
                const Quatf twist = twistAbout(glm::conjugate(second) * hand, rest);
                second = glm::normalize(second * glm::slerp(Quatf(1, 0, 0, 0), twist.w < 0 ? -twist : twist, kWristTwistShare));
                set(side.hand, hand);
            }
        }
        set(side.upperArm, first), set(side.lowerArm, second);
        if (!out_.tracked[side.hand]) set(side.hand, second);
    }

    void leg(size_t s, const Side& side, const Quatf& hips) {
        if (!has({kHip + s, kKnee + s, kAnkle + s})) return;
        const Vec3f upper = at_[kKnee + s] - at_[kHip + s], lower = at_[kAnkle + s] - at_[kKnee + s];
        if (!(glm::length(upper) > kLeastM) || !(glm::length(lower) > kLeastM)) return;
        const auto [first, second] = hingedLimb(hips, Vec3f(0, -1, 0), Vec3f(1, 0, 0), upper, lower);  // a shin bends back
        set(side.upperLeg, first), set(side.lowerLeg, second);
        if (!has({kHeel + s, kFootIndex + s})) return;
        const Vec3f ahead = at_[kFootIndex + s] - at_[kHeel + s];
        if (!(glm::length(ahead) > kLeastM)) return;
        const Quatf foot = glm::normalize(shortestTurn(second * Vec3f(0, 0, 1), ahead) * second);
        set(side.foot, foot), set(side.toes, foot);
    }

    std::span<const Vec3f> at_;
    std::span<const uint8_t> tracked_;
    PointBones& out_;
};

}  // namespace

std::span<const Vec3f> standardRest() {
    static const std::vector<Vec3f> rest = [] {
        std::vector<Vec3f> at(humanoidBoneNames().size(), Vec3f(0, 1.6f, 0));
        const auto put = [&](const std::string& bone, const Vec3f& p) { at[boneIndex(bone)] = p; };
        put("hips", {0, 0.95f, 0}), put("spine", {0, 1.05f, 0}), put("chest", {0, 1.17f, 0}), put("upperChest", {0, 1.28f, 0});
        put("neck", {0, 1.45f, 0}), put("head", {0, 1.55f, 0}), put("jaw", {0, 1.55f, 0.03f});
        for (const float sign : {1.0f, -1.0f}) {
            const std::string s = sign > 0 ? "left" : "right";
            put(s + "Eye", {sign * 0.03f, 1.62f, 0.07f}), put(s + "Shoulder", {sign * 0.05f, 1.4f, 0});
            put(s + "UpperArm", {sign * 0.17f, 1.4f, 0}), put(s + "LowerArm", {sign * 0.44f, 1.4f, 0}),
                put(s + "Hand", {sign * 0.69f, 1.4f, 0});
            put(s + "UpperLeg", {sign * 0.09f, 0.9f, 0}), put(s + "LowerLeg", {sign * 0.09f, 0.49f, 0}),
                put(s + "Foot", {sign * 0.09f, 0.08f, 0});
            put(s + "Toes", {sign * 0.09f, 0.02f, 0.13f});
            float z = 0.03f;
            for (const std::string finger : {"Index", "Middle", "Ring", "Little"}) {
                for (const auto& [segment, x] : {std::pair("Proximal", 0.78f), {"Intermediate", 0.81f}, {"Distal", 0.84f}})
                    put(s + finger + segment, {sign * x, 1.4f, z});
                z -= 0.02f;
            }
            for (const auto& [segment, x] : {std::pair("Metacarpal", 0.71f), {"Proximal", 0.74f}, {"Distal", 0.77f}})
                put(s + "Thumb" + segment, {sign * x, 1.4f, 0.02f + (x - 0.69f)});
        }
        return at;
    }();
    return rest;
}

void bonesFromPoints(std::span<const Vec3f> points, std::span<const uint8_t> tracked, PointBones& out) {
    Solver(points, tracked, out).run();
}

}  // namespace dpl
