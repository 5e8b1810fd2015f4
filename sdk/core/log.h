// SPDX-License-Identifier: Apache-2.0
// One log sink for the process's library code. Silent below `warning` until somebody sets a sink.
#pragma once

#include <functional>
#include <string_view>

#include "sdk/core/result.h"

namespace dpl {

enum class LogLevel : uint8_t { Debug, Info, Warning, Error };

using LogSink = std::function<void(LogLevel, std::string_view)>;

/** Replaces the sink (default: warnings and errors to stderr). Any thread; the sink is called under a lock. */
void setLogSink(LogSink sink);
void logText(LogLevel level, std::string_view text);

template <class... Args>
void log(LogLevel level, std::string_view text, const Args&... args) {
    logText(level, formatText(text, args...));
}

}  // namespace dpl
