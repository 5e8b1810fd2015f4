// SPDX-License-Identifier: Apache-2.0
// JPEG and PNG files from outside: size and completeness are known before OpenCV decodes a byte.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct ImageHeader {
    uint32_t widthPx = 0, heightPx = 0;
};

/** Size from the first bytes of a JPEG or PNG file; other formats are refused. Reads at most a few hundred kilobytes. */
Result<ImageHeader> probeImage(const std::filesystem::path& path);

/** The whole file (at most 256 MiB), its size checked against kMaxImagePixels, and every marker (JPEG) or chunk (PNG) walked to the end:
 *  a truncated file is refused here, because decoders fill the missing part with grey and say nothing. */
Result<std::vector<uint8_t>> readCompleteImage(const std::filesystem::path& path);

}  // namespace dpl
