// SPDX-License-Identifier: Apache-2.0
// How long the calling thread has computed. What other threads and programs do meanwhile does not count.
#pragma once

#include <ctime>

namespace dpl {

/** CPU time of the calling thread, milliseconds since it began. */
inline double threadMs() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

}  // namespace dpl
