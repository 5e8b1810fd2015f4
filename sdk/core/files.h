// SPDX-License-Identifier: Apache-2.0
// Whole files in and out. A file is written under a temporary name beside its target and then renamed, so nobody reads half a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

constexpr uint64_t kMaxFileBytes = uint64_t(4) << 30;

/** Looks at the first bytes of a file (fewer than kFileHeadBytes in a short one) and at its size; refuses it before the rest is read. */
constexpr size_t kFileHeadBytes = 4096;
using CheckFileHead = Status (*)(std::span<const uint8_t> head, uint64_t fileBytes);

/** Reads a regular file of at most `maxBytes`. Errors name the path and the remedy. `check` may be null. */
Result<std::vector<uint8_t>> readFile(const std::filesystem::path& path, uint64_t maxBytes = kMaxFileBytes, CheckFileHead check = nullptr);

/** Writes `path` completely or not at all; parent folders must exist. The bytes are on disk (fsync) before the rename. A symbolic link
 * stays a link: the file that it names is replaced. What is no regular file (a device, a pipe) is written to as it stands, not replaced. */
Status writeFileAtomically(const std::filesystem::path& path, std::span<const uint8_t> bytes);
Status writeFileAtomically(const std::filesystem::path& path, std::string_view text);

}  // namespace dpl
