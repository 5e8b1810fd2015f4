// SPDX-License-Identifier: Apache-2.0
// Checks of command-line values. They run while the arguments are parsed, so a bad value is refused before work starts.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dpl {

/** Accepts a finite number from low to high, both included. Used instead of CLI::Range, which accepts NaN. */
CLI::Validator inRange(double low, double high);

/** Accepts a whole number from 0 to high, in digits. The parser itself takes -1 for an unsigned number as the largest one. */
CLI::Validator isWholeNumber(uint64_t high = UINT64_MAX);

/** Width and height of a picture. */
struct PictureSize {
    uint32_t widthPx = 0, heightPx = 0;
};
/** Parses WIDTHxHEIGHT with sides from 1 to 8192; returns nothing for any other text. */
std::optional<PictureSize> parsePictureSize(std::string_view text);
/** Accepts the texts that parsePictureSize accepts. */
CLI::Validator isPictureSize();

/** Accepts a path that a file can be written to: its folder exists, it is not itself a folder, and its extension is one of `extensions`
 *  (with dots; empty: any extension). With `orFolder`, a path without an extension is accepted too and names a folder. */
CLI::Validator isOutputFile(std::vector<std::string> extensions = {}, bool orFolder = false);

/** Throws CLI::ValidationError if `out` is one of `inputs`, which writing it would destroy. Links are followed. Inputs that are empty or
 *  do not exist are skipped. For the callback of a command, where all its arguments are known. */
void refuseInputAsOutput(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs);

/** The error for a first word that names no command: "unknown command 'rendr'; did you mean 'render'? ...". Empty when the word is a
 * command, or may be a value instead, as the avatar of `doppel bench`. Skips options before the command, which take no values. */
std::string unknownCommand(const CLI::App& app, int argc, const char* const* argv);

}  // namespace dpl
