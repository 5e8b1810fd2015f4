// SPDX-License-Identifier: Apache-2.0
// When the steps up to the first pictures were done, for --timings.
#pragma once

#include <string>
#include <vector>

namespace dpl {

class Timings {
public:
    /** Notes that a step is done. Only the first time counts. Main thread. */
    void mark(const std::string& step);
    /** Prints all steps, in milliseconds since the program was started. */
    void print() const;

private:
    struct Mark {
        std::string step;
        double atMs = 0;
    };
    std::vector<Mark> marks_;
};

}  // namespace dpl
