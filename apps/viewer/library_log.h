// SPDX-License-Identifier: Apache-2.0
// The log of the library, from its threads to the frame loop.
#pragma once

#include <doppel/doppel.h>

#include <mutex>
#include <string>
#include <vector>

namespace dpl {

/** Listens to the library while it lives; there is one at a time. */
class LibraryLog {
public:
    static constexpr size_t kMost = 200;  // lines that wait; later ones are dropped

    struct Line {
        std::string text;
        bool warning = false;  // or an error
    };

    LibraryLog();
    ~LibraryLog();
    LibraryLog(const LibraryLog&) = delete;
    LibraryLog& operator=(const LibraryLog&) = delete;

    /** What the library said since the last call, but for details that only its authors need. */
    std::vector<Line> take();

private:
    static void hear(void* self, DplLogLevel level, const char* text);

    std::mutex mutex_;
    std::vector<Line> lines_;
};

}  // namespace dpl
