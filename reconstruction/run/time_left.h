// SPDX-License-Identifier: Apache-2.0
// How long a stage and the whole run still take.
//
// The rest of a stage follows from its own speed. The stages behind it take what they took in runs that were measured (kMeasuredRuns),
// times how much longer or shorter this run has been than those so far. So nothing is said before a fifth of a run is measured: stages
// such as the body fit differ fortyfold from scan to scan (docs/notebook/2026-11-29-time-left.md).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace dpl {

/** What decides how long the stages of a run take beside each other. */
struct RunSize {
    uint32_t steps = 0, polishSteps = 0, poseFitRounds = 0;  // as in RunSettings
    std::string_view lastStage = "report";                   // name of the last one that runs
};

/** The steps of a training that lets the rest of the run end in `seconds` from now. stepS: of one of the run's slowest steps; the stages
 *  behind the training take as much longer or shorter than in the measured runs as the training does. size: without its steps; its rounds
 *  choose the measured run. At least
 *  kLeastSteps, which may be more than there is time for. */
uint32_t stepsWithin(double seconds, double stepS, const RunSize& size);
constexpr uint32_t kLeastSteps = 100, kMostSteps = 1'000'000;

/** Times are seconds of one clock that never goes back. */
class TimeLeft {
public:
    /** Share of the measured seconds of all stages that this run must have behind it. */
    static constexpr double kLeastSeen = 0.15;
    static constexpr size_t kStages = 11;

    /** The stages to come. Without it nothing is said of the run. May come again when more is known. */
    void plan(const RunSize& size);

    /** A stage begins, by its name in the graph, and the one before has ended. */
    void begin(std::string_view stage, double nowS);
    /** share: of the stage, 0 to 1. */
    void hear(double share, double nowS);
    /** The stage is up to date, and took so long in an earlier run. */
    void tookBefore(double seconds);

    double share() const { return share_; }
    /** Nothing: not known yet. */
    std::optional<double> ofStage(double nowS) const;
    std::optional<double> ofRun(double nowS) const;

private:
    struct Row {
        double measuredS = 0;         // in the runs that were measured; 0: this run does not come to it
        std::optional<double> tookS;  // in this run; nothing: it has not ended
    };
    void end(double nowS);
    /** What the whole stage takes at its speed so far. */
    std::optional<double> wholeStageS(double nowS) const;

    std::array<Row, kStages> rows_{};
    std::optional<size_t> current_;  // row of the stage; nothing: none, or one that only some runs have
    bool running_ = false;
    double beganS_ = 0, share_ = 0, beganShare_ = 0;  // beganShare_: where it was when it began, after a checkpoint
    bool shareKnown_ = false;
    std::optional<double> tookBeforeS_;
};

}  // namespace dpl
