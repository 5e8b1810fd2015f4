// SPDX-License-Identifier: Apache-2.0
// What the program `doppel` prints while it works, read line by line.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace dpl {

struct ProgressLine {
    std::string stage, left, detail;  // for people: "export", "12 s left" or "", "frame 3 of 10"
    double share = 0;                 // of the stage, 0 to 1
};

/** A line of a program whose standard error is no terminal: `  export              [######..................]  25 %  12 s left  frame 3`.
 *  Nothing: it is another line. */
std::optional<ProgressLine> parseProgressLine(std::string_view line);

}  // namespace dpl
