// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/limbs_by_shape.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dpl {
namespace {

constexpr float kLimbShare = 0.5f;   // of the longest pair's length: legs and arms are about equally long, fingers and feet are not
constexpr float kHeadShare = 0.08f;  // of the longest pair's length: neck and head are longer
constexpr float kArmOfLeg = 0.66f;   // shoulder to wrist over hip to ankle
constexpr float kUpperOfLowerArm = 1.1f;
constexpr float kPelvisBone = 0.3f;  // of a thigh; a shorter first bone lies in the pelvis
constexpr size_t kHandBranches = 3;  // fingers of a hand at least, where there are any
constexpr float kSameShape = 0.3f;   // share by which the first bones of mirrored branches may differ
constexpr size_t kMostBranches = 8;  // of a joint, the longest, among which a pair is looked for
constexpr size_t kLongestPath = 32;  // joints from the trunk among which knees and elbows are looked for

/** A limb's branch: the joint at which it leaves the trunk, and the way to its farthest end. */
struct Branch {
    std::vector<size_t> path;  // joints, from the trunk outwards
    std::vector<float> along;  // of each, its distance from the first one along the bones
    float before = 0;          // from the trunk to the first one
    float length() const { return before + along.back(); }
};

/** Places in Branch::path. */
struct Bend {
    size_t upper = 0, lower = 0, end = 0;
};

struct Pair {
    size_t trunk = 0;  // joint from which both branches leave
    std::array<Branch, 2> branches;
    float length() const { return std::min(branches[0].length(), branches[1].length()); }
};

class ShapeReader {
public:
    ShapeReader(std::span<const JointData> joints, std::span<const Vec3f> at, std::span<const int> sides)
        : joints_(joints), at_(at), sides_(sides), children_(joints.size()), reach_(joints.size(), 0), ends_(joints.size(), 0) {
        for (size_t j = joints.size(); j-- > 0;) {
            if (children_[j].empty()) ends_[j] = 1;
            if (joints[j].parent < 0) continue;
            const size_t parent = size_t(joints[j].parent);
            children_[parent].push_back(j);
            reach_[parent] = std::max(reach_[parent], extentOf(j));
            ends_[parent] += ends_[j];
        }
    }

    std::optional<std::vector<std::string>> run() {
        findPairs();
        const auto found = legsAndArms();
        if (!found) return std::nullopt;
        const auto& [legs, arms] = *found;
        std::array<Bend, 2> knees, elbows;
        for (size_t i = 0; i < 2; ++i) {
            const auto knee = kneeOf(legs->branches[i]);
            if (!knee) return std::nullopt;
            knees[i] = *knee;
        }
        const float legM = 0.5f * (spanOf(legs->branches[0], knees[0]) + spanOf(legs->branches[1], knees[1]));
        for (size_t i = 0; i < 2; ++i) {
            const auto elbow = elbowOf(arms->branches[i], legM);
            if (!elbow) return std::nullopt;
            elbows[i] = *elbow;
        }
        bones_.assign(joints_.size(), {});
        const Vec3f left = leftOf(*legs, knees, *arms, elbows);
        nameLegs(*legs, knees, leftFirst(*legs, knees, left));
        nameArms(*arms, elbows, leftFirst(*arms, elbows, left));
        nameHead(*arms, legs->length());
        return std::move(bones_);
    }

private:
    float boneOf(size_t j) const {  // length from the parent
        return joints_[j].parent < 0 ? 0.0f : glm::length(joints_[j].restPosition - joints_[size_t(joints_[j].parent)].restPosition);
    }
    float extentOf(size_t j) const { return boneOf(j) + reach_[j]; }
    bool isAbove(size_t ancestor, size_t joint) const {
        for (int32_t j = int32_t(joint); j >= 0; j = joints_[size_t(j)].parent)
            if (size_t(j) == ancestor) return true;
        return false;
    }
    Branch branchFrom(size_t joint) const {
        Branch out;
        out.before = boneOf(joint);
        float along = 0;
        for (size_t j = joint;;) {
            out.path.push_back(j), out.along.push_back(along);
            if (children_[j].empty() || out.path.size() == kLongestPath) return out;
            j = *std::max_element(children_[j].begin(), children_[j].end(), [&](size_t a, size_t b) { return extentOf(a) < extentOf(b); });
            along += boneOf(j);
        }
    }

    /** Branches of one joint whose first bones mirror each other; a hand may hold something. */
    void findPairs() {
        for (size_t j = 0; j < joints_.size(); ++j) {
            std::vector<size_t> sorted = children_[j];
            std::sort(sorted.begin(), sorted.end(), [&](size_t a, size_t b) { return extentOf(a) > extentOf(b); });
            sorted.resize(std::min(sorted.size(), kMostBranches));
            for (size_t i = 0; i + 1 < sorted.size(); ++i)
                for (size_t k = i + 1; k < sorted.size(); ++k) {
                    Pair pair{j, {branchFrom(sorted[i]), branchFrom(sorted[k])}};
                    if (pair.branches[0].path.size() >= 3 && pair.branches[1].path.size() >= 3 && mirrors(pair))
                        pairs_.push_back(std::move(pair));
                }
        }
    }
    bool mirrors(const Pair& pair) const {
        float both = 0, differ = 0;
        for (size_t i = 0; i < 3; ++i) {
            const float a = boneOf(pair.branches[0].path[i]), b = boneOf(pair.branches[1].path[i]);
            both += 0.5f * (a + b), differ += std::abs(a - b);
        }
        return differ <= kSameShape * both;
    }

    /** Of the long pairs, those of one person: arms leave the trunk farther from the root than legs. */
    std::optional<std::pair<const Pair*, const Pair*>> legsAndArms() const {
        float longest = 0;
        for (const Pair& pair : pairs_) longest = std::max(longest, pair.length());
        std::vector<const Pair*> found;
        for (const Pair& pair : pairs_)
            if (pair.length() >= kLimbShare * longest) found.push_back(&pair);
        const auto carries = [&](const Pair& pair, const Pair& other) {  // a limb of `pair` carries `other`
            return isAbove(pair.branches[0].path[0], other.trunk) || isAbove(pair.branches[1].path[0], other.trunk);
        };
        std::optional<std::pair<const Pair*, const Pair*>> best;
        float bestLength = 0;
        for (const Pair* a : found)
            for (const Pair* b : found) {
                if (a == b || a->trunk == b->trunk || carries(*a, *b) || carries(*b, *a)) continue;
                if (isAbove(b->trunk, a->trunk) || (!isAbove(a->trunk, b->trunk) && ends_[a->trunk] > ends_[b->trunk])) continue;
                if (a->length() + b->length() > bestLength) best = {a, b}, bestLength = a->length() + b->length();
            }
        if (best && fingers(*best->first) >= kHandBranches && fingers(*best->second) < kHandBranches) std::swap(best->first, best->second);
        return best;
    }
    size_t fingers(const Pair& pair) const { return std::min(ends_[pair.branches[0].path[0]], ends_[pair.branches[1].path[0]]); }

    static float spanOf(const Branch& b, const Bend& bend) { return b.along[bend.end] - b.along[bend.upper]; }

    /** The bend with the least cost among all triples of joints along the branch. */
    template <class Cost>
    std::optional<Bend> bestBend(const Branch& b, Cost cost) const {
        std::optional<Bend> best;
        float least = 1e30f;
        for (size_t u = 0; u + 2 < b.path.size(); ++u)
            for (size_t l = u + 1; l + 1 < b.path.size(); ++l)
                for (size_t e = l + 1; e < b.path.size(); ++e) {
                    const float upper = b.along[l] - b.along[u], lower = b.along[e] - b.along[l];
                    if (!(upper > 1e-6f) || !(lower > 1e-6f)) continue;
                    const float c = cost(Bend{u, l, e}, upper, lower);
                    if (c < least) least = c, best = Bend{u, l, e};
                }
        return best;
    }
    /** Thigh and shin are equally long, and take most of a leg. */
    std::optional<Bend> kneeOf(const Branch& b) const {
        auto best = bestBend(b, [&](const Bend&, float upper, float lower) {
            return std::abs(std::log(upper / lower)) + 0.5f * (1 - (upper + lower) / b.length());
        });
        // A short first bone is part of the pelvis: a hip's half of it, or a buttock.
        const auto beginsInPelvis = [&] {
            return b.along[best->upper + 1] - b.along[best->upper] < kPelvisBone * (b.along[best->lower] - b.along[best->upper]);
        };
        while (best && best->upper + 1 < best->lower && beginsInPelvis()) ++best->upper;
        return best;
    }
    std::optional<Bend> elbowOf(const Branch& b, float legM) const {
        return bestBend(b, [&](const Bend& bend, float upper, float lower) {
            float cost = std::abs(std::log(upper / lower / kUpperOfLowerArm)) + std::abs(std::log((upper + lower) / (kArmOfLeg * legM)));
            if (children_[b.path[bend.end]].size() >= kHandBranches) cost -= 0.5f;
            for (size_t i = 0; i < bend.end; ++i)
                if (children_[b.path[i]].size() >= kHandBranches + 1) cost += 1;  // beyond the palm
            return cost;
        });
    }

    Vec3f middleOf(const Pair& pair, const std::array<Bend, 2>& bends, size_t Bend::*joint) const {
        return 0.5f * (at_[pair.branches[0].path[bends[0].*joint]] + at_[pair.branches[1].path[bends[1].*joint]]);
    }

    /** Direction to the person's left, not unit. */
    Vec3f leftOf(const Pair& legs, const std::array<Bend, 2>& knees, const Pair& arms, const std::array<Bend, 2>& elbows) const {
        const Vec3f up = middleOf(arms, elbows, &Bend::upper) - middleOf(legs, knees, &Bend::end);
        if (!(glm::length(up) > 1e-6f)) return Vec3f(1, 0, 0);
        const Vec3f y = glm::normalize(up);
        Vec3f ahead(0);
        float feet = 0;
        for (size_t i = 0; i < 2; ++i) {
            const Branch& leg = legs.branches[i];
            if (knees[i].end + 1 >= leg.path.size()) continue;
            const Vec3f foot = at_[leg.path.back()] - at_[leg.path[knees[i].end]];
            ahead += foot - y * glm::dot(foot, y), feet += glm::length(foot);
        }
        if (!(glm::length(ahead) > 0.3f * feet) || !(feet > 0)) {
            const bool zUp = std::abs(y.z) > std::abs(y.y) && std::abs(y.z) > std::abs(y.x);
            ahead = zUp ? Vec3f(0, -y.z, 0) : Vec3f(0, 0, 1);
        }
        return glm::cross(y, ahead);
    }

    /** Whether the first branch is the left one: by names, else by where it leaves the trunk. */
    bool leftFirst(const Pair& pair, const std::array<Bend, 2>& bends, const Vec3f& left) const {
        std::array<int, 2> votes{};
        for (size_t i = 0; i < 2; ++i)
            for (size_t k = 0; k <= bends[i].end; ++k) votes[i] += sides_[pair.branches[i].path[k]];
        if (votes[0] * votes[1] < 0) return votes[0] > 0;
        return glm::dot(at_[pair.branches[0].path[bends[0].upper]] - at_[pair.branches[1].path[bends[1].upper]], left) >= 0;
    }

    bool isEndSite(size_t joint) const {
        return children_[joint].empty() && joints_[joint].parent >= 0 &&
               joints_[joint].name == joints_[size_t(joints_[joint].parent)].name + " end";
    }

    void nameLegs(const Pair& legs, const std::array<Bend, 2>& bends, bool leftIsFirst) {
        for (size_t i = 0; i < 2; ++i) {
            const std::string side = (i == 0) == leftIsFirst ? "left" : "right";
            const std::vector<size_t>& path = legs.branches[i].path;
            bones_[path[bends[i].upper]] = side + "UpperLeg", bones_[path[bends[i].lower]] = side + "LowerLeg";
            bones_[path[bends[i].end]] = side + "Foot";
            if (bends[i].end + 1 < path.size() && !isEndSite(path[bends[i].end + 1])) bones_[path[bends[i].end + 1]] = side + "Toes";
        }
    }

    void nameArms(const Pair& arms, const std::array<Bend, 2>& bends, bool leftIsFirst) {
        for (size_t i = 0; i < 2; ++i) {
            const std::string side = (i == 0) == leftIsFirst ? "left" : "right";
            const std::vector<size_t>& path = arms.branches[i].path;
            if (bends[i].upper > 0) bones_[path[0]] = side + "Shoulder";
            bones_[path[bends[i].upper]] = side + "UpperArm", bones_[path[bends[i].lower]] = side + "LowerArm";
            if (!isEndSite(path[bends[i].end])) bones_[path[bends[i].end]] = side + "Hand";
        }
    }

    /** The longest branch between the arms. Where it forks (eyes, jaw) is the head; else its last joint but for an end. */
    void nameHead(const Pair& arms, float legM) {
        std::optional<size_t> first;
        for (size_t child : children_[arms.trunk]) {
            if (child == arms.branches[0].path[0] || child == arms.branches[1].path[0] || extentOf(child) < kHeadShare * legM) continue;
            if (!first || extentOf(child) > extentOf(*first)) first = child;
        }
        if (!first) return;
        const Branch neck = branchFrom(*first);
        size_t head = 0;
        while (head + 1 < neck.path.size() && children_[neck.path[head]].size() < 2) ++head;
        const bool forks = children_[neck.path[head]].size() >= 2;
        // Without a fork, a last bone that is longer than the one before it reaches from the head's joint to its top.
        if (!forks && head > 0) {
            const float last = neck.along[head] - neck.along[head - 1], before = head > 1 ? neck.along[head - 1] - neck.along[head - 2] : 0;
            if (isEndSite(neck.path[head]) || (before > 0 && last > 1.2f * before)) --head;
        }
        bones_[neck.path[head]] = "head";
    }

    std::span<const JointData> joints_;
    std::span<const Vec3f> at_;
    std::span<const int> sides_;
    std::vector<std::vector<size_t>> children_;
    std::vector<float> reach_;  // from a joint to its farthest end along the bones
    std::vector<size_t> ends_;  // joints without children below it
    std::vector<Pair> pairs_;
    std::vector<std::string> bones_;
};

}  // namespace

std::optional<std::vector<std::string>> limbsByShape(std::span<const JointData> joints, std::span<const Vec3f> at,
                                                     std::span<const int> sides) {
    if (joints.size() < 10 || at.size() != joints.size() || sides.size() != joints.size()) return std::nullopt;
    for (size_t j = 0; j < joints.size(); ++j)
        if (joints[j].parent >= int32_t(j)) return std::nullopt;
    return ShapeReader(joints, at, sides).run();
}

}  // namespace dpl
