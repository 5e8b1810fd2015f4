// SPDX-License-Identifier: Apache-2.0
// Scores of an avatar on the NeuMan data set, as papers publish them (docs/reference/neuman.md).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/judging/report/lpips.h"

namespace dpl {

struct PublishedScore {
    double psnrDb = 0;            // over the whole picture; equal pictures: 100
    double ssim = 0;              // over the whole picture without a border of 5 pixels
    std::optional<double> lpips;  // where weights were given
};

/** Scores an RGBA picture (straight alpha, 4 bytes per pixel) against a frame of the same size. Both are white outside the frame's mask,
 *  so nothing that is drawn there counts. Pictures must be larger than 10 × 10. */
Result<PublishedScore> scoreAsPublished(std::span<const uint8_t> rgba, const ImageRgb8& truth, const ImageGrey8& mask, const Lpips* lpips);

/** Mean of each score over the frames. LPIPS only if all have it. Nothing without frames. */
std::optional<PublishedScore> meanOf(std::span<const PublishedScore> scores);

}  // namespace dpl
