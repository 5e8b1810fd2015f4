// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/timings.h"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

namespace dpl {
namespace {

/** When the system started this process, seconds of CLOCK_BOOTTIME, in steps of the system's clock tick (10 ms). 0 if it cannot be told. */
double startedAtS() {
    std::ifstream file("/proc/self/stat");
    std::string text((std::istreambuf_iterator<char>(file)), {});
    const size_t name = text.rfind(')');  // the second field may hold spaces
    if (name == text.npos) return 0;
    std::istringstream rest(text.substr(name + 1));
    std::string field;
    constexpr int kStartTimeAfterName = 20;
    for (int i = 0; i < kStartTimeAfterName; ++i) rest >> field;
    double ticks = 0;
    std::istringstream(field) >> ticks;
    return ticks / double(sysconf(_SC_CLK_TCK));
}

double sinceStartMs() {
    static const double started = startedAtS();
    timespec now{};
    clock_gettime(CLOCK_BOOTTIME, &now);
    return 1e3 * (double(now.tv_sec) + 1e-9 * double(now.tv_nsec) - started);
}

}  // namespace

void Timings::mark(const std::string& step) {
    if (std::none_of(marks_.begin(), marks_.end(), [&](const Mark& m) { return m.step == step; })) marks_.push_back({step, sinceStartMs()});
}

void Timings::print() const {
    std::printf("milliseconds since the program was started:\n");
    for (const Mark& mark : marks_) std::printf("%8.0f  %s\n", mark.atMs, mark.step.c_str());
}

}  // namespace dpl
