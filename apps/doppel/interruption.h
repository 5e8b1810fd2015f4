// SPDX-License-Identifier: Apache-2.0
// Ends every command soon after Ctrl-C, even if its work does not stop by itself.
#pragma once

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>

#include "reconstruction/run/progress.h"

namespace dpl {

/** The exit code of work(), which runs on a thread of its own. If work() goes on for longer than `patience` after Ctrl-C, or until a second
 *  one, the process ends at once with the exit code of stopped(), which says so. That loses what a kill loses: files appear by a rename,
 * and programs that the work runs have ended within 0.5 s. What work() throws is thrown on. */
template <class Work, class Stopped>
int endedSoonAfterInterrupt(Work work, Stopped stopped, std::chrono::milliseconds patience = std::chrono::milliseconds(700)) {
    constexpr std::chrono::milliseconds kPoll{20};
    auto code = std::async(std::launch::async, std::move(work));
    while (!Progress::cancelled())
        if (code.wait_for(kPoll) == std::future_status::ready) return code.get();
    const auto until = std::chrono::steady_clock::now() + patience;
    while (!Progress::hurried() && std::chrono::steady_clock::now() < until)
        if (code.wait_for(kPoll) == std::future_status::ready) return code.get();
    const int stoppedCode = stopped();
    std::fflush(nullptr);
    std::_Exit(stoppedCode);
}

}  // namespace dpl
