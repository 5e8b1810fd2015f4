// SPDX-License-Identifier: Apache-2.0
#include "sdk/visibility/governor.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace dpl {

constexpr double kMost = std::numeric_limits<uint32_t>::max();

SplatLimits Governor::next(double budgetMs, const FrameTiming& timing) {
    if (!(budgetMs > 0)) {
        *this = {};
        return {};
    }
    if (state_ == BudgetState::Off) state_ = BudgetState::Untimed;
    const bool usable = timing.ms > 0 && timing.ms <= kGovernorLongestMs && timing.drawn > 0 && timing.last.drawn > 0;
    if (timing.frame <= lastFrame_ || !usable) return limits();
    lastFrame_ = timing.frame;
    perMs_[frames_ % kGovernorWindow] = double(timing.drawn) / timing.ms;
    ++frames_;
    if (timing.ms > budgetMs) ++framesOver_;
    if (frames_ >= kGovernorWindow) steer(budgetMs * drawnPerMs(), timing.last);
    return limits();
}

/** inBudget: drawn splats that would take the whole budget. */
void Governor::steer(double inBudget, const DetailTotals& last) {
    const double load = double(last.drawn) / inBudget, fits = kGovernorAim * inBudget;
    const double wantedDrawn = std::min(double(last.wantedDrawn), kMost), wantedKept = std::min(double(last.wantedKept), kMost);
    const double kept = std::min(double(last.kept), kMost), floor = kGovernorFloor * wantedKept;
    if (load > kGovernorHigh) falling_ = true;
    if (load <= kGovernorAim) falling_ = false;
    calm_ = load < kGovernorLow || wantedDrawn <= fits ? calm_ + 1 : 0;
    if (state_ == BudgetState::Untimed) state_ = BudgetState::Free, limit_ = wantedDrawn;

    if (state_ == BudgetState::Free && !falling_ && last.drawn >= last.wantedDrawn) {
        // The picture does not depend on the limit, which follows what fits: those who join find the right one.
        limit_ = std::max(std::min({fits, limit_ * (1 + kGovernorRise), kMost}), wantedDrawn);
        return;
    }
    if (state_ == BudgetState::Free) limit_ = kept;
    const bool least = kept > limit_;  // one splat of each group is kept for any limit
    if (falling_) {
        rising_ = false;
        if (kept > floor) limit_ = std::max(kept * (1 - kGovernorFall), floor);
    } else {
        if (calm_ >= kGovernorPatience) rising_ = true;
        if (load >= kGovernorAim) rising_ = false;
        if (rising_) limit_ *= 1 + kGovernorRise;
    }
    state_ = (least || std::min(kept, limit_) <= floor) && load > kGovernorHigh ? BudgetState::Unreachable : BudgetState::Limited;
    if (limit_ >= wantedKept) state_ = BudgetState::Free, limit_ = wantedDrawn;
}

SplatLimits Governor::limits() const {
    const auto limit = uint32_t(limit_);
    return state_ == BudgetState::Free ? SplatLimits{limit, 0} : SplatLimits{0, limit};
}

/** Median of the last frames. */
double Governor::drawnPerMs() const {
    double sorted[kGovernorWindow];
    std::copy(std::begin(perMs_), std::end(perMs_), sorted);
    std::sort(std::begin(sorted), std::end(sorted));
    return sorted[kGovernorWindow / 2];
}

}  // namespace dpl
