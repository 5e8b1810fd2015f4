// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/library_log.h"

#include <cstdio>
#include <string_view>
#include <utility>

namespace dpl {

LibraryLog::LibraryLog() {
    (void)dplSetLogCallback(&LibraryLog::hear, this);
}

LibraryLog::~LibraryLog() {
    (void)dplSetLogCallback(nullptr, nullptr);
}

void LibraryLog::hear(void* self, DplLogLevel level, const char* text) {
    if (level < DPL_LOG_INFO) return;
    const bool warning = level >= DPL_LOG_WARNING;
    // The line of a call that failed begins with its name. The viewer says what that means, where it means something.
    if (std::string_view(text).starts_with("dpl")) return;
    if (warning) std::fprintf(stderr, "doppel %s: %s\n", level == DPL_LOG_ERROR ? "error" : "warning", text);
    LibraryLog& log = *static_cast<LibraryLog*>(self);
    std::lock_guard lock(log.mutex_);
    if (log.lines_.size() < kMost) log.lines_.push_back({text, warning});
}

std::vector<LibraryLog::Line> LibraryLog::take() {
    std::lock_guard lock(mutex_);
    return std::exchange(lines_, {});
}

}  // namespace dpl
