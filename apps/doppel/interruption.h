// SPDX-License-Identifier: Apache-2.0
// Ends commands that run stages soon after Ctrl-C, even if a stage does not stop by itself.
#pragma once

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>

#include "apps/doppel/talk.h"
#include "reconstruction/pipeline/progress.h"

namespace dpl {

/** The result of work(), a Result. If work() goes on for more than 0.7 s after Ctrl-C, says so and ends the process at once. That loses
 *  what a kill loses, the stage's own work: files appear by a rename, and programs that a stage runs have ended within 0.5 s. */
template <class Work>
auto endedSoonAfterInterrupt(const Talk& talk, Progress& progress, Work work) {
    constexpr std::chrono::milliseconds kPatience{700}, kPoll{50};
    auto result = std::async(std::launch::async, std::move(work));
    while (!progress.cancelled())
        if (result.wait_for(kPoll) == std::future_status::ready) return result.get();
    if (result.wait_for(kPatience) == std::future_status::ready) return result.get();
    const int code = talk.fail(Error{Code::Cancelled, "stopped"});
    std::fflush(nullptr);
    std::_Exit(code);
}

}  // namespace dpl
