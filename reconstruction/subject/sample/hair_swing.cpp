// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/hair_swing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/sample/subject.h"

namespace dpl {
namespace {

const Vec3d kGravity(0, -9.81, 0);
constexpr size_t kHeld = 2;           // nodes that are stiff with the head
constexpr size_t kMaxNodes = 32;      // of a lock
constexpr double kFastestMPerS = 10;  // keeps the energy finite in any motion
constexpr double kStiffRoot = 4;      // how much higher the frequency of the pull is at the root
constexpr int kRounds = 2;            // of lengths and solids in turn
constexpr double kGrip = 0.02;        // share of the sliding along a solid that it stops in each step
constexpr double kFacesBodyM = 0.03;  // nearer to the body than this, a lock lies flat on it

Vec3d limited(const Vec3d& v, double most) {
    const double length = glm::length(v);
    if (!(length < 1e9)) return Vec3d(0);
    return length > most ? v * (most / length) : v;
}

/** Moves free nodes so that every link gets its length, to first order: a linear system in the shares by which links shorten. */
void holdLengths(Vec3d* p, size_t count, double linkM) {
    std::array<Vec3d, kMaxNodes> n;
    std::array<double, kMaxNodes> share, above;  // above: of the matrix after elimination
    for (size_t i = kHeld; i < count; ++i) n[i] = glm::normalize(p[i] - p[i - 1]);
    for (size_t i = kHeld; i < count; ++i) {
        const bool first = i == kHeld;
        const double below = first ? 0 : -glm::dot(n[i - 1], n[i]);
        const double pivot = (first ? 1 : 2) - (first ? 0 : below * above[i - 1]);
        above[i] = i + 1 < count ? -glm::dot(n[i], n[i + 1]) / pivot : 0;
        share[i] = (glm::length(p[i] - p[i - 1]) - linkM - (first ? 0 : below * share[i - 1])) / pivot;
    }
    for (size_t i = count - 1; i-- > kHeld;) share[i] -= above[i] * share[i + 1];
    for (size_t i = kHeld; i < count; ++i) p[i] += (i + 1 < count ? share[i + 1] * n[i + 1] : Vec3d(0)) - share[i] * n[i];
}

void keepOut(Vec3d* p, const Vec3d* before, const HairLock& lock, size_t count, const PosedSolids& solids) {
    for (size_t i = kHeld; i < count; ++i) {
        const PosedSolids::Near near = solids.nearest(p[i]);
        if (near.distanceM >= lock.clearanceM[i]) continue;
        p[i] += (lock.clearanceM[i] - near.distanceM) * near.outward;
        const Vec3d moved = p[i] - before[i];
        p[i] -= kGrip * (moved - near.outward * glm::dot(moved, near.outward));
    }
}

std::vector<Vec3d> restNodes(const HairLocks& hair) {
    std::vector<Vec3d> nodes;
    for (const HairLock& lock : hair.locks)
        for (const LockNode& node : lock.rest) nodes.push_back(node.at);
    return nodes;
}

}  // namespace

LockChains::LockChains(const HairLocks& hair, std::vector<Vec3d> start)
    : hair_(hair), at_(std::move(start)), speed_(at_.size(), Vec3d(0)), next_(at_) {}

void LockChains::step(const Mat3x4d& worldFromHead, const PosedSolids& solids) {
    for (size_t i = 0; i < hair_.locks.size(); ++i) step(i, worldFromHead, solids);
}

void LockChains::step(size_t index, const Mat3x4d& worldFromHead, const PosedSolids& solids) {
    const HairLock& lock = hair_.locks[index];
    const size_t count = hair_.nodesPerLock;
    Vec3d *at = &at_[index * count], *speed = &speed_[index * count], *p = &next_[index * count];
    const double w = 6.283185307179586 * hair_.frequencyHz, drag = 2 * hair_.damping * w;
    for (size_t i = 0; i < count; ++i) {
        const Vec3d groomed = transformed(worldFromHead, lock.groomed[i]);
        if (i < kHeld) {
            p[i] = groomed;
            continue;
        }
        const double fromTip = 1 - double(i) / double(count - 1), stiff = w * (1 + kStiffRoot * fromTip * fromTip * fromTip);
        // Semi-implicit Euler is stable here: stiff · kStepS is at most 0.17.
        speed[i] += kStepS * (kGravity + stiff * stiff * (groomed - at[i]) - drag * speed[i]);
        p[i] = at[i] + kStepS * limited(speed[i], kFastestMPerS);
    }
    for (int round = 0; round < kRounds; ++round) {
        holdLengths(p, count, lock.linkM());
        keepOut(p, at, lock, count, solids);
    }
    // What the solids have stretched since, from the root to the tip.
    for (size_t i = kHeld; i < count; ++i) p[i] = p[i - 1] + lock.linkM() * glm::normalize(p[i] - p[i - 1]);
    for (size_t i = 0; i < count; ++i) {
        speed[i] = limited((p[i] - at[i]) / kStepS, kFastestMPerS);
        at[i] = p[i];
    }
}

std::vector<LockNode> facingNodes(const std::vector<Vec3d>& nodes, const Vec3d& facing, const PosedSolids& solids) {
    std::vector<LockNode> out;
    Vec3d before = facing;
    for (size_t i = 0; i < nodes.size(); ++i) {
        const Vec3d along = glm::normalize(nodes[std::min(i + 1, nodes.size() - 1)] - nodes[i > 0 ? i - 1 : 0]);
        const auto upright = [&](const Vec3d& v) { return v - along * glm::dot(v, along); };
        const PosedSolids::Near near = solids.nearest(nodes[i]);
        const double body = std::clamp(1 - near.distanceM / kFacesBodyM, 0.0, 1.0);
        const Vec3d kept = upright(before);
        const Vec3d mixed = kept + body * upright(near.outward);
        if (glm::length(mixed) > 1e-3) before = glm::normalize(mixed);
        out.push_back({nodes[i], before});
    }
    return out;
}

HairSwing::HairSwing(const Subject& subject, const SampleMotion& motion)
    : subject_(subject), motion_(motion), chains_(subject.hair, restNodes(subject.hair)) {}

std::vector<LockNode> HairSwing::at(double timeS) {
    const HairLocks& hair = subject_.hair;
    if (!hair.swing()) return {};
    const auto transformsAt = [&](int64_t step) {
        return truthTransforms(subject_.joints, motion_.pose(double(step) * LockChains::kStepS));
    };
    const int64_t target = int64_t(std::llround(timeS / LockChains::kStepS));
    for (; step_ < target; ++step_) {
        const auto worldFromRest = transformsAt(step_ + 1);
        chains_.step(worldFromRest[kHead], PosedSolids(*hair.solids, worldFromRest));
    }
    const auto worldFromRest = transformsAt(step_);
    const PosedSolids solids(*hair.solids, worldFromRest);
    const Mat3d turn(worldFromRest[kHead][0], worldFromRest[kHead][1], worldFromRest[kHead][2]);
    std::vector<LockNode> out;
    const size_t count = hair.nodesPerLock;
    for (size_t i = 0; i < hair.locks.size(); ++i) {
        const auto first = chains_.nodes().begin() + std::ptrdiff_t(i * count);
        const auto nodes = facingNodes({first, first + std::ptrdiff_t(count)}, turn * hair.locks[i].rest[0].facing, solids);
        out.insert(out.end(), nodes.begin(), nodes.end());
    }
    return out;
}

}  // namespace dpl
