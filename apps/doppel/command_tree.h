// SPDX-License-Identifier: Apache-2.0
// The commands and options of `doppel` as values, read from the command-line parser. Completions and the manual page are written from them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace dpl {

struct CommandOption {
    std::vector<std::string> names;  // with dashes; a positional has one name without
    std::string help;
    std::string fallback;              // the default value as text; empty: none is shown
    std::vector<std::string> choices;  // the only values that it takes; empty: any
    bool positional = false, takesValue = false, required = false;
    bool number = false;  // takes a number; other free values may be paths
};

struct CommandEntry {
    std::vector<std::string> path;  // {"doppel", "body", "import"}
    std::string help, footer;
    std::vector<CommandOption> options;
    std::vector<CommandEntry> commands;

    /** It does something by itself, without one of its commands. */
    bool standsAlone() const;
};

/** The tree below `app`. Hidden commands and options are left out. */
CommandEntry commandTree(const CLI::App& app);

/** `entry` and everything below it, parents first. */
std::vector<const CommandEntry*> allCommands(const CommandEntry& entry);

/** Words with `between` in between. */
std::string joined(const std::vector<std::string>& words, const std::string& between);

}  // namespace dpl
