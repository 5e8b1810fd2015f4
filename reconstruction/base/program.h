// SPDX-License-Identifier: Apache-2.0
// Runs another program, without a shell.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct ProgramRun {
    std::vector<std::string> arguments;                    // the first is the program: a path, or a name that is looked up in PATH
    std::vector<std::string> environment = {};             // "NAME=value", added to the environment of this process
    std::filesystem::path log = {};                        // standard output and standard error are appended here; empty: nowhere
    std::function<void(std::string_view line)> line = {};  // called for every line of output, on the calling thread; may be empty
    const std::atomic<bool>* cancel = nullptr;             // when it turns true, the program and its children are killed; may be null
    double timeoutS = 0;                                   // seconds after which it is killed; 0: none
    int input = -1;  // descriptor that becomes its standard input; stays the caller's; −1: it reads nothing
};

/** Runs a program to its end. It has its own process group, so Ctrl-C reaches it only through the task of this thread or `cancel`, within
 *  half a second. NotFound: there is no such program. Cancelled: one of these two. Io: the program failed or
 *  ran longer than `timeoutS`; the message has its name, how it ended, its last line of output and the log, if there is one. Call from any
 * thread. */
Status runProgram(const ProgramRun& run);

/** A program that is fed through its standard input, by runProgram() on a thread of its own. For use by one thread. */
class FedProgram {
public:
    /** `run.input` and `run.cancel` are not used. NotFound: there is no such program. */
    static Result<std::unique_ptr<FedProgram>> start(ProgramRun run);
    FedProgram(const FedProgram&) = delete;
    FedProgram& operator=(const FedProgram&) = delete;
    /** Kills the program if finish() was not called. */
    ~FedProgram();

    /** Blocks until the program has taken the bytes. Io: it no longer reads; finish() says why. */
    Status write(std::span<const uint8_t> bytes);
    /** Ends its input and waits for its end. Errors are those of runProgram(). Call once. */
    Status finish();

private:
    FedProgram() = default;
    int input_ = -1;
    std::atomic<bool> cancel_{false};
    std::thread thread_;
    Status end_;
};

/** A path as a word of a shell command: 'my photos' in quotes, photos/a.jpg as it is. */
std::string shellWord(const std::filesystem::path& path);

/** The file that runProgram would start for `name`, or nullopt. */
std::optional<std::filesystem::path> findProgram(const std::string& name);

}  // namespace dpl
