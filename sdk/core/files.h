// SPDX-License-Identifier: Apache-2.0
// Reads and writes whole files. A file is written under a temporary name beside its target and then renamed, so that no reader sees half
// a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

constexpr uint64_t kMaxFileBytes = uint64_t(4) << 30;

constexpr size_t kFileHeadBytes = 4096;
/** Decides from the first kFileHeadBytes (fewer if the file is shorter) and the size whether a file is read. An error stops readFile before
 *  it reads the rest. */
using CheckFileHead = Status (*)(std::span<const uint8_t> head, uint64_t fileBytes);

/** Reads a regular file of at most `maxBytes`. `check` may be null. Errors name the path and, where known, a remedy. NotFound: there is no
 *  such file. InvalidArgument: a folder, a pipe or a device; it never waits for one. CorruptData: the file grew or shrank meanwhile. */
Result<std::vector<uint8_t>> readFile(const std::filesystem::path& path, uint64_t maxBytes = kMaxFileBytes, CheckFileHead check = nullptr);

/** The path at the end of a chain of symbolic links. A file need not exist there. */
std::filesystem::path endOfLinks(std::filesystem::path path);

/** Writes `path` completely or not at all. Parent folders must exist. The bytes are on disk (fsync) before the rename. A symbolic link is
 *  kept and its target is replaced; built with MinGW, the link is replaced. A device or a pipe is written to directly, not replaced. */
Status writeFileAtomically(const std::filesystem::path& path, std::span<const uint8_t> bytes);
Status writeFileAtomically(const std::filesystem::path& path, std::string_view text);

}  // namespace dpl
