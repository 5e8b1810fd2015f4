// SPDX-License-Identifier: Apache-2.0
// Keeps drawing within a time by keeping fewer splats (docs/reference/level-of-detail.md, "Frame budget").
//
//   times of finished frames ─► splats per millisecond ─► share of the budget that the last draw takes ─► limits of the next draw
//
// It has no clock and uses only × and ÷, so the same times give the same limits on every machine.
#pragma once

#include <cstdint>

#include "sdk/visibility/detail.h"

namespace dpl {

/** What a governor goes by before a draw. */
struct FrameTiming {
    uint64_t frame = 0;  // number of the last finished frame, rising from 1; 0: none has finished
    double ms = 0;       // its time; 0: the device has no clock
    uint64_t drawn = 0;  // its DetailTotals::drawn
    DetailTotals last;   // of the last draw, which need not have finished
};

constexpr double kGovernorAim = 0.85;        // of the budget: where a change of the limit ends
constexpr double kGovernorHigh = 0.95;       // of the budget: frames above it lower the limit
constexpr double kGovernorLow = 0.75;        // of the budget: frames below it raise the limit
constexpr double kGovernorFall = 0.08;       // share by which one frame lowers the limit
constexpr double kGovernorRise = 0.02;       // and by which one raises it
constexpr uint32_t kGovernorPatience = 30;   // frames in a row that must give a reason before the limit rises
constexpr uint32_t kGovernorWindow = 5;      // frames of the median, so two outliers in five change nothing
constexpr double kGovernorFloor = 1.0 / 16;  // of the wanted splats: the limit does not fall further
constexpr double kGovernorLongestMs = 1e4;   // longer times are measuring errors

enum class BudgetState : uint8_t {
    Off,          // no budget
    Untimed,      // fewer than kGovernorWindow frames with a usable time have finished
    Free,         // all wanted splats are drawn; the limit is SplatLimits::drawn
    Limited,      // fewer are drawn; the limit is SplatLimits::kept
    Unreachable,  // as few as the floor allows are drawn, and frames still take longer than the budget
};

/** Governs one picture. One thread at a time; allocates nothing. */
class Governor {
public:
    /** Limits of the next draw. Call it once before each draw. budgetMs: finite; 0: no budget, and what was learned is forgotten. A frame
     * that was seen before, or whose time is not finite, not above 0 or above kGovernorLongestMs, changes nothing. */
    SplatLimits next(double budgetMs, const FrameTiming& timing);

    SplatLimits limits() const;  // that next() returned last
    BudgetState state() const { return state_; }
    uint32_t framesOver() const { return framesOver_; }  // that took longer than the budget

private:
    double drawnPerMs() const;
    void steer(double inBudget, const DetailTotals& last);

    double perMs_[kGovernorWindow] = {};  // drawn splats of the last frames over their times
    uint32_t frames_ = 0, framesOver_ = 0;
    uint64_t lastFrame_ = 0;
    double limit_ = 0;   // of drawn splats while the state is Free, else of kept ones; 0: none yet
    uint32_t calm_ = 0;  // frames in a row that gave a reason to rise
    bool falling_ = false, rising_ = false;
    BudgetState state_ = BudgetState::Off;
};

}  // namespace dpl
