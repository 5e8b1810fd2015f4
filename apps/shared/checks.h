// SPDX-License-Identifier: Apache-2.0
// Checks of command-line values. They run while the arguments are parsed, so a bad value is refused before any work is done.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dpl {

/** Accepts a finite number from low to high, both included. CLI::Range lets NaN pass. */
CLI::Validator inRange(double low, double high);

/** Width and height of a picture. */
struct PictureSize {
    uint32_t widthPx = 0, heightPx = 0;
};
/** Parses WIDTHxHEIGHT with sides from 1 to 8192; nothing for any other text. */
std::optional<PictureSize> parsePictureSize(std::string_view text);
/** Accepts what parsePictureSize does. */
CLI::Validator isPictureSize();

/** Accepts a path that a file can be written to: the folder exists, the path is no folder, and its extension is one of `extensions` (with
 *  their dots). No extensions: any will do. `orFolder`: a path without an extension is accepted too and names a folder. */
CLI::Validator isOutputFile(std::vector<std::string> extensions = {}, bool orFolder = false);

/** What is wrong with the first word that should name a command: "unknown command 'rendr'; did you mean 'render'? ...". Empty when nothing
 *  is. Options before the command are skipped; they take no values. */
std::string unknownCommand(const CLI::App& app, int argc, const char* const* argv);

}  // namespace dpl
