// SPDX-License-Identifier: Apache-2.0
// Checks size and completeness of JPEG and PNG files before OpenCV decodes them.
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

/** Reads a whole file of at most 256 MiB. Checks the picture's size against kMaxImagePixels and walks every marker (JPEG) or chunk (PNG)
 *  to the end. Truncated files are refused, because decoders fill the missing part with grey without an error. */
Result<std::vector<uint8_t>> readCompleteImage(const std::filesystem::path& path);

/** Size of a picture that is complete: the checks of readCompleteImage. */
Result<ImageHeader> probeCompleteImage(const std::filesystem::path& path);

/** Whether the compressed pixels of a picture can be decoded. CorruptData: they are damaged. */
Status checkPicturePixels(const std::filesystem::path& path);

/** The checks of readCompleteImage on bytes that were read already. */
Status checkCompleteImage(std::span<const uint8_t> bytes, const std::filesystem::path& path);

}  // namespace dpl
