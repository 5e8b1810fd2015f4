// SPDX-License-Identifier: Apache-2.0
// The governor steers simulated devices.
#include "sdk/visibility/governor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace dpl {
namespace {

constexpr double kBudgetMs = 10;
constexpr uint64_t kSplats = 200'000;

/** A frame takes load · (fixedMs + perSplatMs · drawn splats), times noise. Drawn are the kept ones and half as many that fade. The time of
 * a frame is known `latency` frames later. */
struct Device {
    double fixedMs = 2, perSplatMs = 6.0 / kSplats;
    int latency = 3;       // 1: CPU renderer; 3: all slots of a GPU in flight
    double noise = 0;      // half width of the uniform factor around 1
    int outlierEvery = 0;  // every so many frames one takes four times as long; 0: none
    std::function<double(int)> load = [](int) { return 1.0; };
    std::function<uint64_t(int)> wanted = [](int) { return kSplats; };  // kept
    uint64_t least = 0;                                                 // splats are kept for any limit
    bool far = false;                                                   // the host's level of detail makes half as many fade; else none
    std::function<double(int)> budgetMs = [](int) { return kBudgetMs; };
};

struct Frame {
    FrameTiming timing;  // that the governor was given before this frame
    double budgetMs = 0;
    SplatLimits limits;  // that it returned
    BudgetState state = BudgetState::Off;
    uint64_t wanted = 0, wantedDrawn = 0, kept = 0, drawn = 0;
    double ms = 0;
    double trueMs = 0;  // without noise
};

std::vector<Frame> run(const Device& device, int count, uint32_t seed = 1) {
    Governor governor;
    std::mt19937 random(seed);
    std::vector<Frame> frames;
    for (int n = 0; n < count; ++n) {
        Frame f;
        f.budgetMs = device.budgetMs(n);
        if (n >= device.latency) {
            const Frame& finished = frames[size_t(n - device.latency)];
            f.timing = {uint64_t(n - device.latency) + 1, finished.ms, finished.drawn, {}};
        }
        if (n > 0) f.timing.last = {frames.back().drawn, frames.back().kept, frames.back().wantedDrawn, frames.back().wanted};
        f.limits = governor.next(f.budgetMs, f.timing);
        f.state = governor.state();
        f.wanted = device.wanted(n);
        f.kept = f.wanted;
        f.drawn = f.wantedDrawn = device.far ? f.wanted + f.wanted / 2 : f.wanted;
        if (f.limits.drawn > 0 && f.drawn > f.limits.drawn) f.drawn = f.limits.drawn, f.kept = f.drawn * 2 / 3;
        if (f.limits.kept > 0 && f.kept > f.limits.kept)
            f.kept = std::max<uint64_t>(f.limits.kept, device.least), f.drawn = std::min(f.wantedDrawn, f.kept + f.kept / 2);
        f.trueMs = device.load(n) * (device.fixedMs + device.perSplatMs * double(f.drawn));
        f.ms = f.trueMs * (1 + device.noise * (2 * double(random()) / double(std::mt19937::max()) - 1));
        if (device.outlierEvery > 0 && n % device.outlierEvery == device.outlierEvery - 1) f.ms *= 4;
        frames.push_back(f);
    }
    return frames;
}

/** How often the splats turn from falling to rising or back, in frames [first, last). */
int turns(const std::vector<Frame>& frames, size_t first, size_t last) {
    int count = 0, direction = 0;
    for (size_t n = std::max<size_t>(first, 1); n < last; ++n) {
        const int now = frames[n].kept > frames[n - 1].kept ? 1 : frames[n].kept < frames[n - 1].kept ? -1 : 0;
        if (now != 0 && direction != 0 && now != direction) ++count;
        if (now != 0) direction = now;
    }
    return count;
}

int framesOver(const std::vector<Frame>& frames, size_t first, size_t last, double Frame::*time = &Frame::ms) {
    return int(std::count_if(frames.begin() + ptrdiff_t(first), frames.begin() + ptrdiff_t(last),
                             [&](const Frame& f) { return f.*time > f.budgetMs; }));
}

/** No frame draws more than 8 % fewer or 2 % more than the one before it, but for the rounding to whole splats. */
void expectSmallSteps(const std::vector<Frame>& frames) {
    for (size_t n = 1; n < frames.size(); ++n) {
        const double before = double(frames[n - 1].kept), now = double(frames[n].kept);
        ASSERT_GE(now, before * (1 - kGovernorFall) - 1) << "frame " << n;
        ASSERT_LE(now, before * (1 + kGovernorRise) + 1) << "frame " << n;
    }
}

/** Frames from `first` on until no later frame before `last` is over the budget. */
int framesUntilSteady(const std::vector<Frame>& frames, size_t first, size_t last) {
    size_t steady = first;
    for (size_t n = first; n < last; ++n)
        if (frames[n].trueMs > frames[n].budgetMs) steady = n + 1;
    return int(steady - first);
}

constexpr size_t kStep = 180, kBack = 270, kEnd = 500;  // at 90 Hz the load trebles for a second

double trebles(int n) {
    return size_t(n) >= kStep && size_t(n) < kBack ? 3 : 1;
}

TEST(Governor, aLoadThatTreblesForASecondCostsAThirdOfASecond) {
    for (const double fixedMs : {0.0, 1.0, 2.0}) {
        for (const int latency : {1, 3}) {
            Device device;
            device.fixedMs = fixedMs, device.latency = latency, device.load = trebles;
            const std::vector<Frame> frames = run(device, kEnd);
            expectSmallSteps(frames);
            EXPECT_EQ(framesOver(frames, 0, kStep), 0);
            EXPECT_EQ(frames[kStep - 1].state, BudgetState::Free);
            EXPECT_GT(frames[kStep].ms, 1.4 * kBudgetMs) << "the step is no challenge";
            const int steady = framesUntilSteady(frames, kStep, kBack);
            EXPECT_LE(steady, 30);
            EXPECT_EQ(frames[kBack - 1].state, BudgetState::Limited);
            EXPECT_GE(frames[kBack - 1].ms, kGovernorAim * (1 - kGovernorFall) * kBudgetMs) << "it gave up more than it had to";
            EXPECT_EQ(frames[kBack - 1].kept, frames[kStep + 45].kept) << "it does not hold";
            EXPECT_EQ(framesOver(frames, kBack, kEnd), 0);
            EXPECT_EQ(turns(frames, 0, kEnd), 1) << "down, and back up";
            size_t back = kBack;
            while (back < kEnd && frames[back].kept < kSplats) ++back;
            EXPECT_LE(back - kBack, 160u);
            EXPECT_EQ(frames[kEnd - 1].state, BudgetState::Free);
            std::printf(
                "[ STEADY   ] load x3, %.0f %% of a frame fixed, time known after %d frames: steady after %d frames, "
                "all splats back %d frames after the load\n",
                100 * fixedMs / (fixedMs + 6), latency, steady, int(back - kBack));
        }
    }
}

TEST(Governor, afterALoadItRisesAsFarAsFits) {
    Device device;
    device.load = [](int n) { return n < 90 ? 3 : n < 500 ? 1.8 : n < 600 ? 3 : 1.8; };
    const std::vector<Frame> frames = run(device, 1000);
    expectSmallSteps(frames);
    for (const size_t rested : {size_t(450), size_t(999)}) {
        EXPECT_EQ(frames[rested].state, BudgetState::Limited);
        EXPECT_NEAR(frames[rested].ms, kGovernorAim * kBudgetMs, 0.04 * kBudgetMs);
    }
    EXPECT_EQ(turns(frames, 0, frames.size()), 3) << "down, up, down, up";
}

TEST(Governor, aLoadThatComesBackWhileItRisesIsMetAgain) {
    Device device;
    device.fixedMs = 0, device.perSplatMs = 8.0 / kSplats;
    device.load = [](int n) { return n < 90 ? 3 : n < 160 ? 1 : 2; };
    const std::vector<Frame> frames = run(device, 400);
    expectSmallSteps(frames);
    EXPECT_GT(frames[160].kept, frames[100].kept) << "it did not rise when the load came back";
    EXPECT_LE(framesUntilSteady(frames, 160, 400), 20);
    EXPECT_EQ(turns(frames, 166, 400), 0) << "it goes on rising where it left off";
}

TEST(Governor, noiseAndOutliersDoNotMakeItSwing) {
    for (uint32_t seed = 1; seed <= 20; ++seed) {
        Device device;
        device.load = trebles, device.noise = 0.1, device.outlierEvery = 17;
        const std::vector<Frame> step = run(device, 1200, seed);
        expectSmallSteps(step);
        EXPECT_LE(framesUntilSteady(step, kStep, kBack), 34) << "seed " << seed;
        EXPECT_LE(turns(step, 0, step.size()), 1) << "seed " << seed;
        EXPECT_GT(step.back().kept, 0.94 * kSplats) << "seed " << seed;
        // A steady load that needs a third of the splats, for 20 s.
        device.load = [](int) { return 2.5; };
        const std::vector<Frame> rest = run(device, 1800, seed);
        EXPECT_LE(turns(rest, 0, rest.size()), 1) << "seed " << seed;
        EXPECT_EQ(framesOver(rest, 60, rest.size(), &Frame::trueMs), 0) << "seed " << seed;
        EXPECT_GT(rest.back().trueMs, 0.65 * kBudgetMs) << "seed " << seed;
    }
}

TEST(Governor, theSameHoldsFarAwayWhereSplatsFadeAnyway) {
    Device device;
    device.far = true, device.perSplatMs = 4.0 / kSplats, device.load = trebles;
    const std::vector<Frame> frames = run(device, kEnd);
    expectSmallSteps(frames);
    EXPECT_LE(framesUntilSteady(frames, kStep, kBack), 30);
    EXPECT_EQ(turns(frames, 0, kEnd), 1);
    EXPECT_EQ(frames[kEnd - 1].state, BudgetState::Free);
    EXPECT_EQ(frames[kEnd - 1].drawn, kSplats * 3 / 2);
}

TEST(Governor, singleOutliersChangeNothing) {
    Device device;
    const std::vector<Frame> quiet = run(device, 300);
    device.outlierEvery = 4;
    const std::vector<Frame> frames = run(device, 300);
    for (size_t n = 0; n < frames.size(); ++n) ASSERT_EQ(frames[n].kept, quiet[n].kept) << n;
    EXPECT_EQ(frames.back().state, BudgetState::Free);
}

TEST(Governor, splatsThatWouldNotFitNeverAppear) {
    Device device;  // after two seconds others join: eight times the splats
    device.fixedMs = 1, device.perSplatMs = 3.0 / kSplats;
    device.wanted = [](int n) { return n < 180 ? kSplats : 8 * kSplats; };
    const std::vector<Frame> frames = run(device, 500);
    EXPECT_EQ(framesOver(frames, 0, frames.size()), 0) << "what fits is known before they come";
    EXPECT_GT(frames[180].kept, kSplats) << "and is used at once";
    EXPECT_EQ(frames.back().state, BudgetState::Limited);
    EXPECT_GT(frames.back().ms, kGovernorLow * kBudgetMs);
}

TEST(Governor, aLoadThatAlternatesIsHeldAtItsHeavyHalf) {
    Device device;  // two cameras in turn
    device.load = [](int n) { return n % 2 ? 3 : 1; };
    const std::vector<Frame> frames = run(device, 600);
    expectSmallSteps(frames);
    EXPECT_EQ(framesOver(frames, 60, frames.size()), 0);
    EXPECT_EQ(turns(frames, 0, frames.size()), 0);
}

TEST(Governor, aBudgetOutOfReachSettlesAtTheFloorAndSaysSo) {
    Device device;
    device.fixedMs = 12, device.budgetMs = [](int n) { return n < 300 ? kBudgetMs : 40; };
    const std::vector<Frame> frames = run(device, 800);
    expectSmallSteps(frames);
    for (size_t n = 60; n < 300; ++n) {
        ASSERT_EQ(frames[n].kept, kSplats / 16) << n;
        ASSERT_EQ(frames[n].state, BudgetState::Unreachable) << n;
    }
    EXPECT_EQ(frames[310].kept, kSplats / 16);
    EXPECT_EQ(frames[310].state, BudgetState::Limited) << "in reach";
    EXPECT_EQ(frames.back().kept, kSplats) << "a larger budget lifts it again";
    EXPECT_EQ(frames.back().state, BudgetState::Free);
}

TEST(Governor, aBudgetIsOutOfReachWhereGroupsAreSmall) {
    Device device;
    device.fixedMs = 12, device.least = kSplats / 4;
    const std::vector<Frame> frames = run(device, 100);
    EXPECT_EQ(frames.back().kept, kSplats / 4);
    EXPECT_EQ(frames.back().state, BudgetState::Unreachable);
    EXPECT_EQ(frames[20].state, BudgetState::Limited);
}

TEST(Governor, whoJoinsAtTheFloorMakesNobodyFiner) {
    Device device;
    device.fixedMs = 12, device.wanted = [](int n) { return n < 100 ? kSplats : 3 * kSplats; };
    const std::vector<Frame> frames = run(device, 200);
    EXPECT_EQ(frames[99].kept, kSplats / 16);
    for (size_t n = 100; n < frames.size(); ++n) {
        ASSERT_EQ(frames[n].kept, kSplats / 16) << n;
        ASSERT_EQ(frames[n].state, BudgetState::Unreachable) << n;
    }
}

TEST(Governor, aBudgetThatFitsLimitsNothing) {
    Device device;
    device.noise = 0.1, device.outlierEvery = 17;
    for (const Frame& f : run(device, 600)) ASSERT_EQ(f.kept, f.wanted);
    device.perSplatMs = 4.0 / kSplats;
    device.wanted = [](int n) { return uint64_t(double(kSplats) * (1 + 0.3 * std::sin(0.02 * n))); };  // somebody walks to and fro
    for (const Frame& f : run(device, 600)) ASSERT_EQ(f.kept, f.wanted);
}

TEST(Governor, aReplayedLogGivesTheSameLimits) {
    Device device;
    device.load = trebles, device.noise = 0.2, device.outlierEvery = 11;
    const std::vector<Frame> frames = run(device, kEnd, 7);
    std::string log;
    char line[200];
    for (const Frame& f : frames) {
        const FrameTiming& t = f.timing;
        std::snprintf(line, sizeof line, "%.17g %.17g %ju %ju %ju %ju %ju %ju\n", f.budgetMs, t.ms, uintmax_t(t.frame), uintmax_t(t.drawn),
                      uintmax_t(t.last.drawn), uintmax_t(t.last.kept), uintmax_t(t.last.wantedDrawn), uintmax_t(t.last.wantedKept));
        log += line;
    }
    Governor replayed;
    std::istringstream in(log);
    for (size_t n = 0; n < frames.size(); ++n) {
        double budgetMs = 0;
        FrameTiming t;
        in >> budgetMs >> t.ms >> t.frame >> t.drawn >> t.last.drawn >> t.last.kept >> t.last.wantedDrawn >> t.last.wantedKept;
        ASSERT_TRUE(in);
        ASSERT_EQ(replayed.next(budgetMs, t), frames[n].limits) << n;
        ASSERT_EQ(replayed.state(), frames[n].state) << n;
    }
}

/** A frame of 1,000 wanted splats, of which the last draw kept `kept`. */
FrameTiming timingOf(uint64_t frame, double ms, uint64_t kept = 1000) {
    const uint64_t drawn = std::min<uint64_t>(1000, kept + kept / 2);
    return {frame, ms, drawn, {drawn, kept, 1000, 1000}};
}

/** The limits after five frames of the same time. */
SplatLimits afterFive(Governor& governor, double ms, uint64_t firstFrame = 1) {
    for (uint64_t n = 0; n < kGovernorWindow; ++n) governor.next(10, timingOf(firstFrame + n, ms));
    return governor.limits();
}

TEST(Governor, theFirstLimitsAreThoseOfTheFormula) {
    const auto first = [](double ms) {
        Governor governor;
        return afterFive(governor, ms);
    };
    EXPECT_EQ(first(9.6), (SplatLimits{0, 920})) << "a step is 8 % at most";
    EXPECT_EQ(first(100), (SplatLimits{0, 920}));
    EXPECT_EQ(first(9.4), (SplatLimits{1000, 0})) << "not above 95 %";
    EXPECT_EQ(first(8.4), (SplatLimits{1011, 0})) << "85 % of the budget at 119 splats a millisecond";
    EXPECT_EQ(first(5), (SplatLimits{1020, 0})) << "1,700 splats fit, but a step is 2 % at most";
}

TEST(Governor, aTimeBelongsToTheSplatsOfItsOwnFrame) {
    Governor governor;  // frames of 2,000 splats took 12 ms; now 1,000 are drawn
    for (uint64_t n = 1; n <= kGovernorWindow; ++n) governor.next(10, {n, 12, 2000, {1000, 1000, 1000, 1000}});
    EXPECT_EQ(governor.state(), BudgetState::Free);
}

TEST(Governor, timesThatCannotBeAreIgnored) {
    const double bad[] = {0,
                          -1,
                          -0.0,
                          std::nan(""),
                          std::numeric_limits<double>::infinity(),
                          -std::numeric_limits<double>::infinity(),
                          1.001 * kGovernorLongestMs,
                          1e300};
    Device device;
    device.load = trebles, device.noise = 0.1;
    Governor clean, fed;
    uint64_t frame = 0;
    for (const Frame& f : run(device, kEnd)) {
        FrameTiming t = f.timing;
        const SplatLimits limit = clean.next(f.budgetMs, t);
        if (t.frame > 0) t.frame = ++frame;
        ASSERT_EQ(fed.next(f.budgetMs, t), limit);
        for (const double ms : bad) {
            FrameTiming wrong = t;
            wrong.frame = ++frame, wrong.ms = ms;
            ASSERT_EQ(fed.next(f.budgetMs, wrong), limit) << ms;
            wrong = t, wrong.frame = ++frame, wrong.drawn = 0;
            ASSERT_EQ(fed.next(f.budgetMs, wrong), limit) << "nothing was drawn";
        }
        ASSERT_EQ(fed.state(), clean.state());
    }
    EXPECT_EQ(fed.framesOver(), clean.framesOver());
    EXPECT_GT(clean.framesOver(), 0u);
}

TEST(Governor, aFrameCountsOnce) {
    Governor governor;
    EXPECT_EQ(afterFive(governor, 30).kept, 920u);
    EXPECT_EQ(governor.next(10, timingOf(5, 30, 920)).kept, 920u);
    EXPECT_EQ(governor.next(10, timingOf(4, 30, 920)).kept, 920u) << "older than what was seen";
    EXPECT_EQ(governor.framesOver(), 5u);
    EXPECT_EQ(governor.next(10, timingOf(6, 30, 920)).kept, 846u);
    EXPECT_EQ(governor.framesOver(), 6u);
    governor.next(10, timingOf(7, 9.9, 846));
    EXPECT_EQ(governor.framesOver(), 6u);
}

TEST(Governor, withoutTimesOrABudgetNothingIsLimited) {
    Governor governor;
    EXPECT_EQ(governor.state(), BudgetState::Off);
    EXPECT_EQ(governor.next(0, timingOf(1, 30, 1000)), SplatLimits());
    EXPECT_EQ(governor.state(), BudgetState::Off);
    for (uint64_t n = 0; n < 9; ++n) EXPECT_EQ(governor.next(10, timingOf(n, 0, 1000)), SplatLimits());
    for (uint64_t n = 10; n < 14; ++n) EXPECT_EQ(governor.next(10, timingOf(n, 30, 1000)), SplatLimits()) << "four frames are too few";
    EXPECT_EQ(governor.state(), BudgetState::Untimed);
    EXPECT_EQ(governor.next(10, timingOf(14, 30, 1000)).kept, 920u);
    EXPECT_EQ(governor.state(), BudgetState::Limited);
    EXPECT_EQ(governor.next(0, timingOf(15, 30, 920)), SplatLimits());
    EXPECT_EQ(governor.state(), BudgetState::Off);
    EXPECT_EQ(governor.framesOver(), 0u) << "it forgets";
    EXPECT_EQ(afterFive(governor, 9, 20).drawn, 1000u);
}

TEST(Governor, extremeNumbersStayNumbers) {
    constexpr uint64_t kHuge = std::numeric_limits<uint64_t>::max();
    for (const double budgetMs : {5e-324, 1e-300, 1.0, 1e300, std::numeric_limits<double>::max()})
        for (const double ms : {5e-324, 1e-300, 1.0, kGovernorLongestMs})
            for (const uint64_t splats : {uint64_t(1), uint64_t(1000), kHuge}) {
                Governor governor;
                uint64_t kept = splats;
                for (uint64_t n = 1; n <= 3000; ++n) {
                    const SplatLimits limits = governor.next(budgetMs, {n, ms, kept, {kept, kept, splats, splats}});
                    if (n >= kGovernorWindow) {
                        ASSERT_GE(limits.drawn + limits.kept, std::min<uint64_t>(splats, 0xffffffff) / 16);
                    }
                    kept = limits.kept > 0 ? std::min<uint64_t>(splats, limits.kept) : splats;
                }
                EXPECT_NE(governor.state(), BudgetState::Untimed);
            }
}

}  // namespace
}  // namespace dpl
