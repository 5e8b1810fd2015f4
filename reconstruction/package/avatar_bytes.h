// SPDX-License-Identifier: Apache-2.0
// Reads the bytes of an avatar or of general splats from a file named by the user.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

/** Reads the whole file. Its first bytes are checked before the rest is read: Unsupported if it is neither an avatar nor general splats,
 *  CorruptData if it is empty or a .glb whose header states another size. Errors name the file and the remedy. */
Result<std::vector<uint8_t>> readAvatarBytes(const std::filesystem::path& path);

}  // namespace dpl
