// SPDX-License-Identifier: Apache-2.0
// What a capture needs besides `doppel` to become an avatar, and how to get what this machine lacks. `doppel import` asks before it names
// the next command, `doppel reconstruct` and `doppel check` before they work for minutes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** Work on a capture that other programs or networks do. */
struct ToolNeeds {
    bool videos = false;     // its frames are still inside videos
    bool keypoints = false;  // no frame has any
    bool masks = false;      // no frame has one
    bool cameras = false;    // none is known
};

ToolNeeds toolNeeds(const Scan& scan);

/** For each tool that is needed and missing on this machine what it is for and how to get it, in the order in which they are used.
 *  `models`: the folder of networks that the user named; empty: installedModels(). */
std::vector<std::string> missingTools(const ToolNeeds& needs, const std::filesystem::path& models = {});

/** "networks and COLMAP": the names of what missingTools() says. */
std::string namesOf(const std::vector<std::string>& missing);

/** "`subject` needs what is missing on this machine ..." and a numbered line for each of `missing`. Every line ends with a line break. */
std::string describeMissing(const std::string& subject, const std::vector<std::string>& missing);

}  // namespace dpl
