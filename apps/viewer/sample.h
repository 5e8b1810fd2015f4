// SPDX-License-Identifier: Apache-2.0
// The built-in sample avatar, which the program `doppel` makes.
#pragma once

#include <atomic>
#include <filesystem>

#include "sdk/core/result.h"

namespace dpl {

/** The clip of the sample that other avatars walk by. */
constexpr const char* kWalk = "walk";

/** The program `doppel` of this viewer: beside it, or in its build tree, or else in PATH. NotFound: a sentence that says what to install.
 */
Result<std::filesystem::path> doppelProgram();

/** The file of the sample avatar in `folder`. `program sample-avatar` makes it, in seconds, unless one of this version is there. The folder
 *  must be there. Cancelled: *cancel has turned true. Io: the program failed; the sentence is its own. */
Result<std::filesystem::path> sampleAvatar(const std::filesystem::path& program, const std::filesystem::path& folder,
                                           const std::atomic<bool>& cancel);

}  // namespace dpl
