// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/time_left.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "reconstruction/run/progress.h"

namespace dpl::test {
namespace {

constexpr RunSize kDraft{3000, 200, 40, "report"};
// What a draft takes beside its stages' speed: the medians of time_left.cpp, in their order.
constexpr double kDraftS[] = {0.6, 12.5, 6.1, 0.5, 14.6, 28.7, 108, 98, 8.2, 24.9, 50};
constexpr const char* kNames[] = {"ingest",      "body-fit", "surface", "body-map", "garments", "register",
                                  "co-optimise", "evidence", "package", "pose-fit", "report"};

/** A run that is `factor` times as slow as the measured ones, on a planted clock. Stops at `share` of a stage. */
struct PlantedRun {
    TimeLeft time;
    double nowS = 1000, factor = 1;
    void to(const char* stage, double share) {
        for (size_t i = next;; ++i) {
            time.begin(kNames[i], nowS);
            time.hear(0, nowS);
            const bool here = std::string(kNames[i]) == stage;
            nowS += factor * kDraftS[i] * (here ? share : 1);
            time.hear(here ? share : 1, nowS);
            if (here) {
                next = i + 1;
                return;
            }
        }
    }
    double truthS(const char* stage, double share) const {
        double left = 0;
        bool behind = false;
        for (size_t i = 0; i < std::size(kNames); ++i) {
            if (behind) left += factor * kDraftS[i];
            if (std::string(kNames[i]) == stage) left += factor * kDraftS[i] * (1 - share), behind = true;
        }
        return left;
    }
    size_t next = 0;
};

TEST(TimeLeft, saysNothingBeforeASeventhIsMeasured) {
    PlantedRun run;
    run.time.plan(kDraft);
    EXPECT_FALSE(run.time.ofRun(run.nowS));
    run.to("body-fit", 1);
    EXPECT_FALSE(run.time.ofRun(run.nowS)) << "13 of 352 seconds are little";
    EXPECT_TRUE(run.time.ofStage(run.nowS)) << "of the stage it knows more";
    run.to("register", 1);
    EXPECT_TRUE(run.time.ofRun(run.nowS));
}

TEST(TimeLeft, followsTheSpeedOfThisRun) {
    for (const double factor : {0.2, 1.0, 7.0}) {
        const std::pair<const char*, double> kPoints[] = {{"register", 0.9}, {"co-optimise", 0.5}, {"evidence", 0.25}, {"report", 0.5}};
        for (const auto& [stage, share] : kPoints) {
            PlantedRun run{.factor = factor};
            run.time.plan(kDraft);
            run.to(stage, share);
            ASSERT_TRUE(run.time.ofRun(run.nowS)) << stage;
            EXPECT_NEAR(*run.time.ofRun(run.nowS), run.truthS(stage, share), 1e-6 * run.truthS(stage, share)) << factor << " " << stage;
        }
    }
}

TEST(TimeLeft, aStageWithoutShareCountsAsTheSlowOnesBefore) {
    PlantedRun run{.factor = 2};
    run.time.plan(kDraft);
    run.to("co-optimise", 1);
    run.time.begin("evidence", run.nowS);
    EXPECT_NEAR(*run.time.ofRun(run.nowS + 40), run.truthS("co-optimise", 1) - 40, 1e-6) << "40 of its 196 seconds have passed";
    EXPECT_NEAR(*run.time.ofRun(run.nowS + 1000), run.truthS("evidence", 1), 1e-6) << "no more than all of it";
}

TEST(TimeLeft, stagesThatOnlySomeRunsHaveAreNotForetold) {
    PlantedRun run;
    run.time.plan(kDraft);
    run.time.begin("observe", run.nowS);
    run.time.hear(0, run.nowS), run.time.hear(0.5, run.nowS + 100);
    EXPECT_NEAR(*run.time.ofStage(run.nowS + 100), 100, 1e-9);
    EXPECT_FALSE(run.time.ofRun(run.nowS + 100));
    run.to("co-optimise", 1);
    const double before = run.truthS("co-optimise", 1);
    run.time.begin("assemble", run.nowS);
    EXPECT_NEAR(*run.time.ofRun(run.nowS + 5), before, 1e-6);
}

TEST(TimeLeft, stagesThatAreUpToDateCountWithWhatTheyTook) {
    TimeLeft time;
    time.plan(kDraft);
    double nowS = 0;
    for (size_t i = 0; i < 7; ++i) {
        time.begin(kNames[i], nowS);
        time.tookBefore(3 * kDraftS[i]);
        nowS += 0.01;
    }
    time.begin("evidence", nowS);
    EXPECT_NEAR(*time.ofRun(nowS), 3 * (98 + 8.2 + 24.9 + 50), 1e-6);
}

TEST(TimeLeft, aTrainingFromACheckpointCountsWhole) {
    PlantedRun run;
    run.time.plan(kDraft);
    run.to("register", 1);
    run.time.begin("co-optimise", run.nowS);
    run.time.hear(0.5, run.nowS);
    run.time.hear(0.75, run.nowS + 27);
    EXPECT_NEAR(*run.time.ofStage(run.nowS + 27), 27, 1e-9);
    EXPECT_NEAR(*run.time.ofRun(run.nowS + 27), run.truthS("co-optimise", 0.75), 1e-6);
    run.time.hear(1, run.nowS + 54);
    run.time.begin("evidence", run.nowS + 54);
    EXPECT_NEAR(*run.time.ofRun(run.nowS + 54), run.truthS("co-optimise", 1), 1e-6);
}

TEST(TimeLeft, otherNumbersScaleTheStagesThatTheyDecide) {
    // Fewer steps: training and most of evidence are shorter beside the others.
    TimeLeft time;
    time.plan({6000, 600, 80, "report"});  // nearer to 10000 than to 3000
    constexpr double kStandardS[] = {0.8, 19, 14.9, 0.5, 24.9, 30.5, 530, 320, 30.4, 72.5, 50};
    double nowS = 0;
    for (size_t i = 0; i < 7; ++i) {
        time.begin(kNames[i], nowS);
        nowS += kStandardS[i] * (i == 6 ? 0.6 : 1);
    }
    time.begin("evidence", nowS);
    EXPECT_NEAR(*time.ofRun(nowS), (0.7 * 0.6 + 0.3) * 320 + 30.4 + 72.5 + 50, 1e-6);
}

TEST(TimeLeft, aCheckOfTheFilmEndsWithTheBody) {
    TimeLeft time;
    time.plan({3000, 200, 40, "body-map"});
    time.begin("ingest", 0), time.begin("body-fit", 0.6);
    time.hear(0, 0.6), time.hear(0.5, 6.85);
    EXPECT_NEAR(*time.ofRun(6.85), 6.25 + 6.6, 1e-6);
}

TEST(TimeLeft, oddSharesStayNumbers) {
    TimeLeft time;
    time.plan({0, 0, 0, "report"});
    time.begin("body-fit", 0);
    for (const double share : {double(NAN), -1.0, 0.0, 2.0, double(INFINITY)}) time.hear(share, 50);
    EXPECT_TRUE(!time.ofStage(60) || std::isfinite(*time.ofStage(60)));
    time.begin("register", 60);
    time.begin("co-optimise", 200);
    ASSERT_TRUE(time.ofRun(300));
    EXPECT_TRUE(std::isfinite(*time.ofRun(300)));
    time.plan({3000, 200, 40, ""});
    EXPECT_FALSE(time.ofRun(300)) << "nothing is told of a run without stages";
}

TEST(ProgressLine, saysTheTimeOfTheStageAndOfTheRun) {
    EXPECT_EQ(progressLine("painting", 0.34, 200, 720, "step 300", 0),
              "  painting            [########................]  34 %  3 min 20 s left, about 12 minutes left in all  step 300");
    EXPECT_EQ(progressLine("painting", 0.5, 80, std::nullopt, "step 300", 0),
              "  painting            [############............]  50 %  80 s left  step 300");
    EXPECT_EQ(progressLine("painting", 0, std::nullopt, std::nullopt, "", 0), "  painting            [........................]   0 %    ");
}

TEST(ProgressLine, fitsItsTerminal) {
    const std::string line = progressLine("painting", 0.5, 200, 720, "step 300 of 2000, 23.1 dB", 80);
    EXPECT_EQ(line, "  painting            [######......]  50 %  about 12 minutes left in all  step ");
    EXPECT_EQ(line.size(), 79u);
}

/** Seconds of a run from the training on, by the table of `standard`, on a machine on which a slow step takes stepS. */
double fromTrainingOn(uint32_t steps, double stepS) {
    const double train = 0.76 * stepS * steps, slower = 0.76 * stepS * 10000 / 530;
    return train * (1 + 224.0 / 530) + slower * (96 + 30.4 + 72.5 + 50);
}

TEST(StepsWithin, theRunEndsInTime) {
    const RunSize standard{0, 600, 80};
    for (const double stepS : {0.02, 0.05, 0.3})
        for (const double minutes : {30.0, 60.0, 300.0}) {
            const double seconds = minutes * 60;
            if (seconds < fromTrainingOn(kLeastSteps, stepS)) continue;
            const uint32_t steps = stepsWithin(seconds, stepS, standard);
            EXPECT_LE(fromTrainingOn(steps, stepS), seconds) << stepS << " s, " << minutes << " min";
            EXPECT_GT(fromTrainingOn(steps + 2, stepS), seconds) << stepS << " s, " << minutes << " min";
        }
}

TEST(StepsWithin, whatPosesFramesTakesItsTimeBeforeSteps) {
    // A scan of 1080 × 1440 by `high`: posing the validation frames alone takes about a sixth of an hour.
    const RunSize high{0, 2000, 120};
    const double stepS = 0.28, slower = 0.76 * stepS * 10000 / 530, behindS = slower * (96 * 1.5 + 30.4 * 2000 / 600 + 72.5 * 1.5 + 50);
    EXPECT_GT(behindS, 1600);
    EXPECT_EQ(stepsWithin(behindS, stepS, high), kLeastSteps);
    EXPECT_NEAR(stepsWithin(behindS + 3600, stepS, high), 3600 / (0.76 * stepS * (1 + 224.0 / 530)), 2);
}

TEST(StepsWithin, moreTimeIsNeverFewerStepsAndALongerStepNeverMore) {
    const RunSize draft{0, 200, 40};
    uint32_t before = 0;
    for (double seconds = 60; seconds < 20000; seconds *= 1.1) {
        const uint32_t steps = stepsWithin(seconds, 0.04, draft);
        EXPECT_GE(steps, before) << seconds;
        EXPECT_LE(stepsWithin(seconds, 0.05, draft), steps) << seconds;
        before = steps;
    }
    EXPECT_GT(before, 50000u);
}

TEST(StepsWithin, thereAreAlwaysSomeAndNeverTooMany) {
    const RunSize draft{0, 200, 40};
    for (const double seconds : {-100.0, 0.0, 10.0, double(NAN)}) EXPECT_EQ(stepsWithin(seconds, 0.04, draft), kLeastSteps) << seconds;
    EXPECT_EQ(stepsWithin(1e9, 0.04, draft), kMostSteps);
    EXPECT_EQ(stepsWithin(600, 0, draft), kMostSteps);
}

}  // namespace
}  // namespace dpl::test
