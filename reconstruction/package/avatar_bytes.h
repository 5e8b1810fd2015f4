// SPDX-License-Identifier: Apache-2.0
// Bytes of an avatar or of general splats, from a file that somebody named on a command line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

/** Reads the whole file. One that is neither an avatar nor general splats, or a .glb whose header states another size than the file has, is
 *  refused by its first bytes, however large it is. Errors name the file and the remedy. */
Result<std::vector<uint8_t>> readAvatarBytes(const std::filesystem::path& path);

}  // namespace dpl
