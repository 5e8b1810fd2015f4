// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/clip_memory.h"

#include <algorithm>
#include <cmath>

#include "sdk/motion/clip.h"

namespace dpl {
namespace {

constexpr size_t kStride = 60, kMostSteps = 600 * kStride;
constexpr double kStepS = 1.0 / 60;

}  // namespace

ClipMemory::ClipMemory(const ClipData& clip, std::span<const JointData> joints, const MotionModeData& motion)
    : clip_(&clip), joints_(joints), motion_(&motion), durationS_(clipDurationS(clip)) {
    if (motion.empty()) return;
    stepS_ = std::max(kStepS, durationS_ / double(kMostSteps));
    const size_t steps = size_t(durationS_ / stepS_);
    setCursor(0, {});
    for (size_t step = 0; step <= steps; step += kStride) {
        advanceTo(step);
        kept_.push_back(cursor_);
    }
    advanceTo(steps);
    samplePose(clip, joints_, durationS_, scratch_);
    scratch_.before = forgetMotion(motion, cursor_, std::max(0.0, durationS_ - double(steps) * stepS_));
    end_ = stateOf(motion, scratch_);
    setRound();
}

void ClipMemory::setRound() {
    // Held is a maximum that leaks, so the rounds before add what the end of one round leaves, and no more. A lag y is linear: it repeats
    // where y(0) = y(D), and differs from the y of one round by what then starts away from it, which leaks.
    round_.held = end_.held;
    for (size_t l = 0, turns = motion_->turnCount(); l < motion_->lagsS.size(); ++l) {
        const double kept = std::exp(-durationS_ / double(motion_->lagsS[l]));
        for (size_t i = l * turns; i < (l + 1) * turns && kept < 1; ++i)
            round_.lagged[i] = (end_.lagged[i] - kept_[0].lagged[i]) / (1 - kept);
    }
}

MotionMemory ClipMemory::at(double timeS, bool loop) {
    if (motion_->empty() || !(timeS > 0 || loop)) return {};
    timeS = timeS > 0 ? timeS : 0.0;
    if (timeS > durationS_) return forgetMotion(*motion_, end_, timeS - durationS_);
    const size_t step = size_t(timeS / stepS_), kept = std::min(step / kStride, kept_.size() - 1);
    if (cursorStep_ > step || cursorStep_ < kept * kStride) cursorStep_ = kept * kStride, cursor_ = kept_[kept];
    advanceTo(step);
    MotionMemory left = forgetMotion(*motion_, cursor_, std::max(0.0, timeS - double(step) * stepS_));
    if (!loop) return left;
    const MotionMemory round = forgetMotion(*motion_, round_, timeS);  // its turns are 0, so of lags nothing but the leak
    for (size_t i = 0; i < left.held.size(); ++i) left.held[i] = std::max(left.held[i], round.held[i]);
    for (size_t i = 0; i < left.lagged.size(); ++i) left.lagged[i] += round.lagged[i];
    return left;
}

void ClipMemory::setCursor(size_t step, const MotionMemory& before) {
    samplePose(*clip_, joints_, double(step) * stepS_, scratch_);
    scratch_.before = before;
    cursor_ = stateOf(*motion_, scratch_);
    cursorStep_ = step;
}

void ClipMemory::advanceTo(size_t step) {
    while (cursorStep_ < step) setCursor(cursorStep_ + 1, forgetMotion(*motion_, cursor_, stepS_));
}

}  // namespace dpl
