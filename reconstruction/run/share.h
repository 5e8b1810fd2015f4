// SPDX-License-Identifier: Apache-2.0
// One file with a person in it, to send.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

struct ShareOptions {
    std::filesystem::path from;  // the output folder of a run, or an avatar file
    std::filesystem::path out;   // the page
    std::filesystem::path web;   // folder of the web module
    std::string name;            // of the person; empty: as the page is called
    std::string licence;         // of the avatar, in words; empty: none is stated
    uint32_t threadCount = 0;    // 0: one a core; the page does not depend on it
};

/** Writes a page that shows the avatar and nothing of its scan: no photographs, names, hashes or paths. It needs no network and no other
 *  file. Returns a line for the terminal. Errors name the file and the remedy. */
Result<std::string> shareAvatar(const ShareOptions& options);

}  // namespace dpl
