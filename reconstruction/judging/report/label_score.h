// SPDX-License-Identifier: Apache-2.0
// The score of one part of the subject, such as hair, in one picture (docs/reference/metrics.md).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

constexpr size_t kLeastLabelPixels = 64;

struct LabelScore {
    double maskedPsnrDb = 0;  // as FrameScore::maskedPsnrDb, over the pixels of the label
    double outlineIou = 0;    // of drawn and true person, over the pixels that lie nearer to this label than to any other
};

/** Scores an RGBA picture (straight alpha) against a frame cut out by its mask (cutOut()). labels: of the same frame; a pixel outside the
 * mask has the label of the person's nearest pixel. nullopt where sizes differ or fewer than kLeastLabelPixels show the label. */
std::optional<LabelScore> scoreLabel(const std::vector<uint8_t>& rgba, const std::vector<uint8_t>& truthRgba, const ImageGrey8& labels,
                                     uint8_t label);

}  // namespace dpl
