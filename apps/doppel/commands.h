// SPDX-License-Identifier: Apache-2.0
// The commands of `doppel`. Each adds its subcommand to the parser; the chosen one runs and returns an exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

/** Exit codes of every command. */
enum ExitCode { kExitOk = 0, kExitFailed = 1, kExitUsage = 2, kExitCancelled = 130 };

/** Set by the command that was parsed; main returns what it returns. */
using CommandRun = std::function<int()>;

void addSampleCommand(CLI::App& app, CommandRun& run);
void addReconstructCommand(CLI::App& app, CommandRun& run);
void addRenderCommand(CLI::App& app, CommandRun& run);
void addInspectCommand(CLI::App& app, CommandRun& run);
void addBenchCommand(CLI::App& app, CommandRun& run);
void addBodyCommand(CLI::App& app, CommandRun& run);
void addExportCommand(CLI::App& app, CommandRun& run);
void addPackCommand(CLI::App& app, CommandRun& run);

/** Prints "doppel: message" to stderr and returns the exit code for it. */
int reportError(const Error& error);

}  // namespace dpl
