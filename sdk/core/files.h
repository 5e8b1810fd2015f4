// SPDX-License-Identifier: Apache-2.0
// Whole files in and out. Writing goes to a temporary name beside the target and is renamed, so a reader never sees half a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

constexpr uint64_t kMaxFileBytes = uint64_t(4) << 30;

/** Reads a regular file of at most `maxBytes`. Errors name the path and the remedy. */
Result<std::vector<uint8_t>> readFile(const std::filesystem::path& path, uint64_t maxBytes = kMaxFileBytes);

/** Writes `path` completely or not at all; parent folders must exist. The bytes are on disk (fsync) before the rename. */
Status writeFileAtomically(const std::filesystem::path& path, std::span<const uint8_t> bytes);
Status writeFileAtomically(const std::filesystem::path& path, std::string_view text);

}  // namespace dpl
