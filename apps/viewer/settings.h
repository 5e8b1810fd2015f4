// SPDX-License-Identifier: Apache-2.0
// What the viewer remembers between its starts: a small JSON file in the folder where the platform keeps settings.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct ViewerSettings {
    static constexpr size_t kMostRecent = 12, kMostPathBytes = 4096, kMostBytes = size_t(1) << 20;

    std::vector<std::string> recent;  // absolute paths, the last opened first
    std::string folder;               // where Open... looked last
    std::string exports;              // the folder that exports go to, as typed; empty: the current one
    std::string room;                 // "dark", "bright", "none", or "" before one was chosen

    /** Puts a file or a folder first. */
    void remember(const std::string& path);
    void forget(const std::string& path);
    bool operator==(const ViewerSettings&) const = default;
};

enum class System : uint8_t { Unix, Mac, Windows };
/** The system that this program was built for. */
System thisSystem();

/** The settings file: in $XDG_CONFIG_HOME/doppel or ~/.config/doppel, ~/Library/Application Support/doppel, or %APPDATA%/doppel. Empty if
 * the system names no such folder. environment: the value of a variable, or "". */
std::filesystem::path settingsFile(System system, const std::function<std::string(const char*)>& environment);

/** What is damaged is left out: the worst file gives empty settings. */
ViewerSettings parseSettings(std::string_view text);
std::string settingsToJson(const ViewerSettings& settings);

/** Reads settings; without a file they are empty. */
ViewerSettings readSettings(const std::filesystem::path& file);
/** Makes the folder if it is not there. */
Status writeSettings(const std::filesystem::path& file, const ViewerSettings& settings);

}  // namespace dpl
