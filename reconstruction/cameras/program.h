// SPDX-License-Identifier: Apache-2.0
// Runs another program, without a shell.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct ProgramRun {
    std::vector<std::string> arguments;                    // the first is the program: a path, or a name that is looked up in PATH
    std::vector<std::string> environment = {};             // "NAME=value", added to the environment of this process
    std::filesystem::path log;                             // standard output and standard error are appended here
    std::function<void(std::string_view line)> line = {};  // called for every line of output, on the calling thread; may be empty
    const std::atomic<bool>* cancel = nullptr;             // when it turns true, the program and its children are killed; may be null
    double timeoutS = 0;                                   // seconds after which it is killed; 0: none
};

/** Runs a program to its end. It reads nothing from standard input and has its own process group, so Ctrl-C reaches it only through
 *  `cancel`, within half a second. NotFound: there is no such program. Cancelled: `cancel` turned true. Io: the program failed or
 *  ran longer than `timeoutS`; the message has its name, how it ended, its last line of output and the log. Call from any thread. */
Status runProgram(const ProgramRun& run);

/** The file that runProgram would start for `name`, or nullopt. */
std::optional<std::filesystem::path> findProgram(const std::string& name);

}  // namespace dpl
