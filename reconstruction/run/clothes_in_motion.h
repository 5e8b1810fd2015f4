// SPDX-License-Identifier: Apache-2.0
// What goes wrong with the clothes of an avatar file that a motion file drives.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/run/progress.h"
#include "reconstruction/subject/garments/cloth_faults.h"
#include "sdk/core/result.h"

namespace dpl {

/** Poses the avatar ten times a second of the clip, at most 200 times, and measures clothFaults(). clip: a BVH or glTF file; animation:
 *  name or number of one in it, empty: the first. Returns text of a few lines, or a JSON object. Errors name the file; Cancelled. */
Result<std::string> clothesInMotion(const std::filesystem::path& avatar, const std::filesystem::path& clip, const std::string& animation,
                                    bool json, Progress& progress);

/** The faults as text of a few lines, and as a JSON object. timesS: of the poses, at least one. */
std::string clothesText(const ClothFaults& faults, const std::filesystem::path& clip, const std::vector<double>& timesS);
std::string clothesJson(const ClothFaults& faults, const std::filesystem::path& clip, const std::vector<double>& timesS);

}  // namespace dpl
