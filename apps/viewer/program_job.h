// SPDX-License-Identifier: Apache-2.0
// The program `doppel` at work for the viewer, on a thread of its own, so that the window never waits for it.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "apps/viewer/progress_line.h"
#include "sdk/core/result.h"

namespace dpl {

class ProgramJob {
public:
    static constexpr size_t kMostLines = 200;

    /** Starts arguments[0], which says every half second how far it is. */
    explicit ProgramJob(std::vector<std::string> arguments);
    /** Ends the program and its children, which takes up to half a second, if it has not ended. */
    ~ProgramJob();
    ProgramJob(const ProgramJob&) = delete;
    ProgramJob& operator=(const ProgramJob&) = delete;

    /** Ends the program; ended() says so within half a second. */
    void cancel() { cancel_ = true; }
    bool cancelled() const { return cancel_; }
    /** The last that it said of it; nothing: it has not yet. */
    std::optional<ProgressLine> progress() const;
    /** Its other lines, at most the last kMostLines. */
    std::vector<std::string> lines() const;
    /** How it ended; nothing: it has not. Errors: the program's own sentence, or how it was started or ended. Cancelled: by cancel(). */
    std::optional<Status> ended() const;

private:
    void hear(std::string_view line);

    std::atomic<bool> cancel_{false};
    mutable std::mutex mutex_;
    std::optional<ProgressLine> progress_;
    std::vector<std::string> lines_;
    std::optional<Status> ended_;
    std::thread thread_;  // last: it uses all of the above
};

}  // namespace dpl
