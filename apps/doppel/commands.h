// SPDX-License-Identifier: Apache-2.0
// The commands of `doppel`. Each function adds its subcommand to the parser; the parsed subcommand then runs and returns an exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

/** Exit codes of every command. */
enum ExitCode { kExitOk = 0, kExitFailed = 1, kExitUsage = 2, kExitCancelled = 130 };

/** The parsed subcommand sets it; main calls it and returns its exit code. */
using CommandRun = std::function<int()>;

void addSampleCommand(CLI::App& app, CommandRun& run);
void addSampleAvatarCommand(CLI::App& app, CommandRun& run);
void addSetupCommand(CLI::App& app, CommandRun& run);
void addCamerasCommand(CLI::App& app, CommandRun& run);
void addCheckCommand(CLI::App& app, CommandRun& run);
void addImportCommand(CLI::App& app, CommandRun& run);
void addReconstructCommand(CLI::App& app, CommandRun& run);
void addPresetsCommand(CLI::App& app, CommandRun& run);
void addEvaluateCommand(CLI::App& app, CommandRun& run);
void addRenderCommand(CLI::App& app, CommandRun& run);
void addInspectCommand(CLI::App& app, CommandRun& run);
void addBenchCommand(CLI::App& app, CommandRun& run);
void addBodyCommand(CLI::App& app, CommandRun& run);
void addExportCommand(CLI::App& app, CommandRun& run);
void addPackCommand(CLI::App& app, CommandRun& run);
void addDressCommand(CLI::App& app, CommandRun& run);
void addShareCommand(CLI::App& app, CommandRun& run);
void addCompletionCommand(CLI::App& app, CommandRun& run);
void addManualCommand(CLI::App& app, CommandRun& run);

/** Prints "doppel: message" to stderr and returns the exit code for it. */
int reportError(const Error& error);

}  // namespace dpl
