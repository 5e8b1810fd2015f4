// SPDX-License-Identifier: Apache-2.0
// The person of the report's first screen, alive.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "reconstruction/judging/report/report.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Hash of what bringToLife() reads from the folder of the web module; "none" where that is not whole, empty where nobody names it. */
std::string livePageKey(const std::filesystem::path& web);

/** Lets the person in the report move: by the clips of the file, then by walkClips(). bytes, avatar: the same file. web: folder of the web
 *  module; where that is not there, the picture stays still and the report says how to get the module. Empty: nobody wants it. */
Status bringToLife(const std::filesystem::path& web, std::span<const uint8_t> bytes, const AvatarData& avatar, ReportData& data);

}  // namespace dpl
