// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/log.h"

#include <cstdio>
#include <mutex>

namespace dpl {
namespace {

void toStderr(LogLevel level, std::string_view text) {
    if (level < LogLevel::Warning) return;
    std::fprintf(stderr, "doppel %s: %.*s\n", level == LogLevel::Error ? "error" : "warning", int(text.size()), text.data());
}

std::mutex sinkMutex;
LogSink& sink() {
    static LogSink value = toStderr;
    return value;
}

}  // namespace

void setLogSink(LogSink newSink) {
    std::lock_guard lock(sinkMutex);
    sink() = newSink ? std::move(newSink) : LogSink(toStderr);
}

void logText(LogLevel level, std::string_view text) {
    std::lock_guard lock(sinkMutex);
    sink()(level, text);
}

}  // namespace dpl
