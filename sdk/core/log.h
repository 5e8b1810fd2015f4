// SPDX-License-Identifier: Apache-2.0
// The log of all library code in the process. The default sink prints warnings and errors to stderr.
#pragma once

#include <functional>
#include <string_view>

#include "sdk/core/result.h"

namespace dpl {

enum class LogLevel : uint8_t { Debug, Info, Warning, Error };

using LogSink = std::function<void(LogLevel, std::string_view)>;

/** Replaces the sink; an empty one restores the default. Any thread. The sink is called under a lock and must not log. */
void setLogSink(LogSink sink);
void logText(LogLevel level, std::string_view text);

template <class... Args>
void log(LogLevel level, std::string_view text, const Args&... args) {
    logText(level, formatText(text, args...));
}

}  // namespace dpl
