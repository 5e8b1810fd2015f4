// SPDX-License-Identifier: Apache-2.0
// An avatar file as a page shows it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct ShownAs {
    std::vector<ClipData> moreClips;         // on the avatar's rig; clips of the file come first, and keep their names
    std::optional<std::string> nameInstead;  // takes the place of the name, which comes from the scan
    bool withoutEvidence = false;            // leaves out what was measured while it was made
};

/** The same avatar, coded as it was, with other clips and words. Splats, mesh and pictures stay as they are. CorruptData and Version as
 *  readAvatar(); InvalidArgument: a clip does not fit the rig. */
Result<std::vector<uint8_t>> shownAvatar(std::span<const uint8_t> bytes, const ShownAs& as);

}  // namespace dpl
