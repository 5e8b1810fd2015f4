// SPDX-License-Identifier: Apache-2.0
// A `doppel reconstruct` that the viewer starts or stops. It has a session of its own, so it goes on when the viewer ends or crashes. Slow
// disks make these calls wait: they belong on a thread.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

/** The file in an output folder that gets what the program prints. */
constexpr const char* kRunLog = "reconstruct.log";

/** Starts the program of the command line in the output folder `out`, which is made, and returns once the run tells of itself there
 *  (progress.json), or holds the folder and works. Errors: NotFound: there is no such program; Io: it cannot be started, or it has ended
 *  before, with its own sentence; Cancelled: *cancel, while the program goes on. */
Status startRun(const std::vector<std::string>& arguments, const std::filesystem::path& out, const std::atomic<bool>& cancel);

/** The process on this machine that holds the output folder (run.lock). NotFound: none does. */
Result<pid_t> processOfRun(const std::filesystem::path& out);

/** Stops the run, as Ctrl-C does: nothing that was finished is lost. Returns when its process has ended, which it may do without a last
 *  word in progress.json. Errors name the folder; Io: it goes on after kStopPatienceS. */
constexpr int kStopPatienceS = 20;  // a run ends within a second, on a machine that is not busy
Status stopRun(const std::filesystem::path& out);

}  // namespace dpl
