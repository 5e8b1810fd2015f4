// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/interruption.h"

#include <gtest/gtest.h>

#include <csignal>
#include <stdexcept>
#include <thread>

namespace {

using namespace dpl;

constexpr int kStopped = 130;

int stopped() {
    std::fputs("stopped", stderr);
    return kStopped;
}

/** Installs the handlers, interrupts itself, as Ctrl-C does unless told, runs `work` and exits with its code. */
template <class Work>
[[noreturn]] void runInterrupted(Work work, int signalNumber = SIGINT) {
    installSignalHandlers();
    std::raise(signalNumber);
    std::exit(endedSoonAfterInterrupt(work, stopped));
}

TEST(Interruption, workThatIsDoneGivesItsExitCode) {
    EXPECT_EQ(endedSoonAfterInterrupt([] { return 3; }, stopped), 3);
}

TEST(Interruption, whatTheWorkThrowsIsThrownOn) {
    const auto throwing = []() -> int { throw std::runtime_error("broken"); };
    EXPECT_THROW(endedSoonAfterInterrupt(throwing, stopped), std::runtime_error);
}

TEST(InterruptionDeathTest, workThatStopsByItselfGivesItsExitCode) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto obedient = [] { return Progress::cancelled() ? 7 : 8; };
    EXPECT_EXIT(runInterrupted(obedient), testing::ExitedWithCode(7), "^$");
}

TEST(InterruptionDeathTest, aTerminalThatClosesInterruptsUnlessItIsIgnored) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto obedient = [] { return Progress::cancelled() ? 7 : 8; };
    EXPECT_EXIT(runInterrupted(obedient, SIGTERM), testing::ExitedWithCode(7), "^$");
    EXPECT_EXIT((std::signal(SIGHUP, SIG_DFL), runInterrupted(obedient, SIGHUP)), testing::ExitedWithCode(7), "^$");
    EXPECT_EXIT((std::signal(SIGHUP, SIG_IGN), runInterrupted(obedient, SIGHUP)), testing::ExitedWithCode(8), "^$");
}

TEST(InterruptionDeathTest, workThatNeverStopsIsEnded) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto endless = []() -> int {
        for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
    };
    EXPECT_EXIT(runInterrupted(endless), testing::ExitedWithCode(kStopped), "stopped");
}

}  // namespace
