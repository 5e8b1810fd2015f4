// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/motion_clock.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dpl {
namespace {

constexpr uint32_t kMagic = 0x4d4c5044, kVersion = 1;  // "DPLM"

/** What save() writes before `count` doubles. */
struct SavedHead {
    uint32_t magic, version;
    uint64_t motion;  // hash of the motion modes
    int64_t shownNs;
    double fadeLeftS;
    uint32_t running, count;
};
static_assert(sizeof(SavedHead) + 2 * sizeof(MotionMemory) + sizeof(MotionState) == kMaxSavedMotionBytes);

/** Calls visit(array, how many of its numbers these motion modes use, least, most) for all of a clock's arrays. */
template <class Memory, class State, class Visit>
void visitNumbers(const MotionModeData& motion, Memory& fresh, Memory& carried, State& shown, const Visit& visit) {
    if (motion.empty()) return;
    constexpr double kMostAngle = 3.2, kMostTurn = 2, kMostLag = 2 * kMostTurn;
    const size_t turns = motion.lagsS.empty() ? 0 : motion.turnCount();
    for (Memory* memory : {&fresh, &carried}) {
        visit(memory->held, motion.heldCount(), 0.0, kMostAngle);
        visit(memory->lagged, motion.lagCount(), -kMostLag, kMostLag);
        visit(memory->earlier, motion.lagsS.size(), 0.0, 1.0);
    }
    visit(shown.held, motion.heldCount(), 0.0, kMostAngle);
    visit(shown.lagged, motion.lagCount(), -kMostLag, kMostLag);
    visit(shown.turns, turns, -kMostTurn, kMostTurn);
}

size_t numberCount(const MotionModeData& motion) {
    size_t total = 0;
    const MotionMemory none;
    const MotionState rest;
    visitNumbers(motion, none, none, rest, [&](const auto&, size_t count, double, double) { total += count; });
    return total;
}

/** Of two memories of one time: the more of what is held, and both lags. */
MotionMemory together(const MotionMemory& a, const MotionMemory& b) {
    MotionMemory both = a;
    for (size_t i = 0; i < both.held.size(); ++i) both.held[i] = std::max(a.held[i], b.held[i]);
    for (size_t i = 0; i < both.lagged.size(); ++i) both.lagged[i] += b.lagged[i];
    return both;
}

/** Seconds from one time to a later one; -1 if it is earlier. The difference of two clocks may exceed an int64_t. */
double secondsFrom(int64_t from, int64_t to) {
    return to < from ? -1.0 : double(uint64_t(to) - uint64_t(from)) * 1e-9;
}

}  // namespace

void MotionClock::advance(const MotionModeData& motion) {
    const double passedS = running_ ? secondsFrom(shownNs_, timeNs_) : -1;
    if (passedS < 0 || passedS > kMotionGapS) {
        carried_ = together(carryMotion(motion, shown_), carried_);
        fadeLeftS_ = kMotionFadeS;
        fresh_ = {};
        return;
    }
    fresh_ = forgetMotion(motion, shown_, passedS);
    const double left = std::max(0.0, fadeLeftS_ - passedS), share = fadeLeftS_ > 0 ? left / fadeLeftS_ : 0;
    for (double& held : carried_.held) held *= share;
    for (double& lagged : carried_.lagged) lagged *= share;
    fadeLeftS_ = left;
}

void MotionClock::show(const MotionModeData& motion, Pose& pose) {
    if (motion.empty()) return;
    if (timed_) {
        if (!running_ || timeNs_ != shownNs_) advance(motion);
        pose.before = fresh_;
        shownNs_ = timeNs_;
    } else {
        fresh_ = pose.before;
        carried_ = {};
    }
    running_ = timed_;
    shown_ = stateOf(motion, pose);
    pose.before = together(fresh_, carried_);
}

void MotionClock::settle(Pose& pose) {
    *this = {};
    pose.before = {};
}

std::vector<uint8_t> MotionClock::save(const MotionModeData& motion) const {
    const SavedHead head{kMagic, kVersion, hashOfMotionModes(motion), shownNs_, fadeLeftS_, running_, uint32_t(numberCount(motion))};
    std::vector<uint8_t> bytes(sizeof head + head.count * sizeof(double));
    std::memcpy(bytes.data(), &head, sizeof head);
    uint8_t* to = bytes.data() + sizeof head;
    visitNumbers(motion, fresh_, carried_, shown_, [&](const auto& numbers, size_t count, double, double) {
        std::memcpy(to, numbers.data(), count * sizeof(double));
        to += count * sizeof(double);
    });
    return bytes;
}

Status MotionClock::restore(const MotionModeData& motion, std::span<const uint8_t> bytes, Pose& pose) {
    SavedHead head{};
    const size_t size = sizeof head + numberCount(motion) * sizeof(double);
    if (bytes.size() >= sizeof head) std::memcpy(&head, bytes.data(), sizeof head);
    if (head.magic != kMagic || head.version != kVersion)
        return fail(Code::InvalidArgument, "{} bytes are no motion state of this library; take those of dplGetMotionState", bytes.size());
    if (head.motion != hashOfMotionModes(motion)) return fail(Code::InvalidArgument, "the motion state is of another avatar");
    if (bytes.size() != size)
        return fail(Code::InvalidArgument, "a motion state of {} bytes; those of this avatar have {}", bytes.size(), size);
    MotionMemory fresh, carried;
    MotionState shown;
    bool possible = head.fadeLeftS >= 0 && head.fadeLeftS <= kMotionFadeS && head.running <= 1;
    const uint8_t* from = bytes.data() + sizeof head;
    visitNumbers(motion, fresh, carried, shown, [&](auto& numbers, size_t count, double least, double most) {
        std::memcpy(numbers.data(), from, count * sizeof(double));
        from += count * sizeof(double);
        for (size_t i = 0; i < count; ++i) possible = possible && numbers[i] >= least && numbers[i] <= most;
    });
    if (!possible) return fail(Code::InvalidArgument, "the motion state holds numbers that no motion gives");
    fresh_ = fresh, carried_ = carried, shown_ = shown;
    shownNs_ = timeNs_ = head.shownNs, fadeLeftS_ = head.fadeLeftS;
    running_ = timed_ = head.running == 1;
    pose.before = together(fresh_, carried_);
    return {};
}

}  // namespace dpl
