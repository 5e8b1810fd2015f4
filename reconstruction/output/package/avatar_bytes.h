// SPDX-License-Identifier: Apache-2.0
// Reads the bytes of an avatar or of general splats from a file named by the user.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Reads the whole file. Its first bytes are checked before the rest is read: Unsupported if it is neither an avatar nor general splats,
 *  CorruptData if it is empty or a .glb whose header states another size. Errors name the file and the remedy. */
Result<std::vector<uint8_t>> readAvatarBytes(const std::filesystem::path& path);

/** What inspect and render say about a file that states no axes. */
constexpr const char* kNoUpAxis = "no up axis stated; try --axes y-down";

/** The avatar in the bytes of a file. `what` is wanted of it, for the error about general splats, which have none: "poses". Errors name the
 *  file. */
Result<AvatarData> avatarOf(const std::filesystem::path& path, std::span<const uint8_t> bytes, std::string_view what);

}  // namespace dpl
