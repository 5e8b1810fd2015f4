// SPDX-License-Identifier: Apache-2.0
// How much a command says while it runs, and whether its result is a sentence or JSON: --quiet, --verbose and --json.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "reconstruction/run/progress.h"
#include "sdk/core/result.h"

namespace dpl {

/** Shared by the options of a command and its run. */
struct Talk {
    bool quiet = false, verbose = false, json = false;

    Progress::Style style() const;
    /** Prints the result on standard output: `text`, or with --json the document, on one line. Returns the exit code for success. */
    int succeed(const std::string& text, const nlohmann::json& document) const;
    /** Prints the sentence on standard error, and with --json {"error": {"code", "message"}} on standard output. Returns the exit code. */
    int fail(const Error& error) const;
};

/** Adds the three options to a command. */
std::shared_ptr<Talk> addTalkOptions(CLI::App& command);

}  // namespace dpl
