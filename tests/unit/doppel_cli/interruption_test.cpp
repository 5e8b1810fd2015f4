// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/interruption.h"

#include <gtest/gtest.h>

#include <csignal>
#include <future>
#include <stdexcept>

#include "tests/unit/wait_until.h"

namespace {

using namespace dpl;

constexpr int kStopped = 130;

int stopped() {
    std::fputs("stopped", stderr);
    return kStopped;
}

/** Installs the handlers, interrupts itself, as Ctrl-C does unless told, runs `work` and exits with its code. Work that stops by itself
 *  gets the time to do so on a busy machine. */
template <class Work>
[[noreturn]] void runInterrupted(Work work, int signalNumber = SIGINT, std::chrono::milliseconds patience = test::kPatience) {
    installSignalHandlers();
    std::raise(signalNumber);
    std::exit(endedSoonAfterInterrupt(work, stopped, patience));
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
    const auto endless = [] {
        std::promise<void> never;
        never.get_future().wait();
        return 0;
    };
    EXPECT_EXIT(runInterrupted(endless, SIGINT, std::chrono::milliseconds(1)), testing::ExitedWithCode(kStopped), "stopped");
}

TEST(InterruptionDeathTest, aSecondInterruptWaitsForNoWork) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto endless = [] {
        std::raise(SIGINT);
        std::promise<void> never;
        never.get_future().wait();
        return 0;
    };
    EXPECT_EXIT(runInterrupted(endless), testing::ExitedWithCode(kStopped), "stopped");
}

}  // namespace
