// SPDX-License-Identifier: Apache-2.0
// The finest picture that a scan has of a frame: hires/ of docs/formats/scan.md. The report alone reads it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"

namespace dpl {

struct FineTruth {
    std::vector<uint8_t> rgba;  // straight alpha, cut out by its mask
    uint32_t widthPx = 0, heightPx = 0;
};

/** The frame's picture at four times the size, otherwise at twice the size. None if the scan has neither, or if they are unreadable or of
 *  the wrong size. `scan` is the scan's folder. */
std::optional<FineTruth> fineTruth(const std::filesystem::path& scan, const TrainFrame& frame);

}  // namespace dpl
