// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/time_left.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/run/stage_words.h"

namespace dpl {
namespace {

/** A run that was measured: seconds of each stage, in the order of placeOfStage(). */
struct MeasuredRun {
    uint32_t steps, polishSteps, poseFitRounds;
    std::array<double, TimeLeft::kStages> seconds;
};
static_assert(TimeLeft::kStages == kStagesOfAll);

// Medians of docs/benchmarks/quality-*.json on 2026-11-29: 8 runs by `draft`, 3 by `standard`; other presets are scaled from the nearer
// one. The last column, the report, is not in those files: the median of 9 drafts on two busy cores. The body
// fit takes 0.26 of what it did in them. Evidence is that of 2026-11-30 beside the training of the same runs. Only ratios count.
constexpr MeasuredRun kMeasuredRuns[] = {
    {3000, 200, 40, {0.6, 12.5, 6.1, 0.5, 14.6, 28.7, 108, 98, 8.2, 24.9, 50}},
    {10000, 600, 80, {0.8, 19, 14.9, 0.5, 24.9, 30.5, 530, 320, 30.4, 72.5, 50}},
};

constexpr double kLeastShare = 0.01, kLeastS = 3;  // of a stage, before its speed says something

std::optional<size_t> rowOf(std::string_view stage) {
    const size_t place = placeOfStage(stage);
    return place == 0 ? std::nullopt : std::optional(place - 1);
}

double ratio(uint32_t ours, uint32_t theirs) {
    return double(ours) / double(theirs);
}

/** away: how far a run is, from 0. */
template <class Away>
const MeasuredRun& nearest(Away away) {
    return *std::min_element(std::begin(kMeasuredRuns), std::end(kMeasuredRuns),
                             [&](const MeasuredRun& a, const MeasuredRun& b) { return away(a) < away(b); });
}

const MeasuredRun& nearestRun(uint32_t steps) {
    return nearest([&](const MeasuredRun& run) { return std::abs(std::log(ratio(std::max(1u, steps), run.steps))); });
}

/** Row of a stage that every run has. */
constexpr size_t kTraining = 6, kEvidence = 7, kPackage = 8, kPoseFit = 9, kReport = 10;
constexpr double kMeanStep =
    0.76;  // mean time of a training's steps, of that of a probe, which also decodes pictures: measured, as the page says

/** Share of evidence in which the validation frames are posed, round by round; the rest trains. */
constexpr double kPosing = 0.3;

}  // namespace

uint32_t stepsWithin(double seconds, double stepS, const RunSize& size) {
    const MeasuredRun& like =
        nearest([&](const MeasuredRun& run) { return std::abs(std::log(ratio(std::max(1u, size.poseFitRounds), run.poseFitRounds))); });
    const double meanS = kMeanStep * std::max(1e-6, stepS), slower = meanS * like.steps / like.seconds[kTraining];
    const double afterS = like.seconds[kPackage] * ratio(size.polishSteps, like.polishSteps) +
                          (like.seconds[kPoseFit] + kPosing * like.seconds[kEvidence]) * ratio(size.poseFitRounds, like.poseFitRounds) +
                          like.seconds[kReport];
    const double perStepS = meanS * (1 + (1 - kPosing) * like.seconds[kEvidence] / like.seconds[kTraining]);
    return uint32_t(std::min(double(kMostSteps), std::max(double(kLeastSteps), (seconds - slower * afterS) / perStepS)));
}

void TimeLeft::plan(const RunSize& size) {
    const MeasuredRun& like = nearestRun(size.steps);
    const auto scaleOf = [&](std::string_view stage) {
        if (stage == "co-optimise") return ratio(size.steps, like.steps);
        if (stage == "evidence")
            return (1 - kPosing) * ratio(size.steps, like.steps) + kPosing * ratio(size.poseFitRounds, like.poseFitRounds);
        if (stage == "package") return ratio(size.polishSteps, like.polishSteps);
        if (stage == "pose-fit") return ratio(size.poseFitRounds, like.poseFitRounds);
        return 1.0;
    };
    const size_t stages = placeOfStage(size.lastStage);
    for (size_t i = 0; i < kStages; ++i) rows_[i].measuredS = i < stages ? like.seconds[i] * scaleOf(stageAt(i + 1)) : 0;
}

void TimeLeft::end(double nowS) {
    if (!running_) return;
    running_ = false;
    if (!current_) return;
    const double part = 1 - beganShare_;  // of the stage, which this run has done
    rows_[*current_].tookS = tookBeforeS_ ? *tookBeforeS_ : part > kLeastShare ? (nowS - beganS_) / part : nowS - beganS_;
}

void TimeLeft::begin(std::string_view stage, double nowS) {
    end(nowS);
    running_ = true;
    current_ = rowOf(stage);
    beganS_ = nowS, share_ = beganShare_ = 0, shareKnown_ = false;
    tookBeforeS_.reset();
}

void TimeLeft::hear(double share, double nowS) {
    share = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0;
    if (!shareKnown_) shareKnown_ = true, beganShare_ = share, beganS_ = nowS;
    share_ = share;
}

void TimeLeft::tookBefore(double seconds) {
    if (seconds > 0) tookBeforeS_ = seconds;
}

std::optional<double> TimeLeft::wholeStageS(double nowS) const {
    const double done = share_ - beganShare_, took = nowS - beganS_;
    if (!running_ || !shareKnown_ || !(done > kLeastShare && took > kLeastS)) return std::nullopt;
    return took / done;
}

std::optional<double> TimeLeft::ofStage(double nowS) const {
    const auto whole = wholeStageS(nowS);
    return whole ? std::optional(*whole * (1 - share_)) : std::nullopt;
}

std::optional<double> TimeLeft::ofRun(double nowS) const {
    const auto whole = wholeStageS(nowS);
    double all = 0, seen = 0, measured = 0, took = 0, behind = 0;  // measured, took: of the stages whose time is known
    for (size_t i = 0; i < kStages; ++i) {
        const Row& row = rows_[i];
        const bool now = running_ && current_ == i;
        all += row.measuredS;
        if (now ? whole.has_value() : row.tookS.has_value()) {
            seen += row.measuredS * (now ? share_ : 1);
            measured += row.measuredS, took += now ? *whole : *row.tookS;
        } else if (!now) {
            behind += row.measuredS;
        }
    }
    if (!(all > 0) || seen < kLeastSeen * all || !(took > kLeastS)) return std::nullopt;
    const double speed = took / measured;
    double rest = 0;
    if (running_ && whole)
        rest = *whole * (1 - share_);
    else if (running_ && current_)
        rest = std::max(0.0, speed * rows_[*current_].measuredS - (nowS - beganS_));
    return rest + speed * behind;
}

}  // namespace dpl
