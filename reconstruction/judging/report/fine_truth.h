// SPDX-License-Identifier: Apache-2.0
// The finest picture that a scan has of a frame: hires/ of docs/formats/scan.md. Only what measures reads it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sdk/math/camera.h"

namespace dpl {

struct FineTruth {
    std::vector<uint8_t> rgba;  // straight alpha, cut out by its mask
    uint32_t widthPx = 0, heightPx = 0;
};

/** The frame's picture at four times the size, otherwise at twice the size. None if the scan has neither, or if they are unreadable or of
 *  the wrong size. `scan` is the scan's folder, `camera` that of the frame's own picture. */
std::optional<FineTruth> fineTruth(const std::filesystem::path& scan, const std::string& frame, const Camerad& camera);

}  // namespace dpl
