// SPDX-License-Identifier: Apache-2.0
// How much of the contrast of printed bars a picture keeps (docs/reference/metrics.md), for scans whose truth says where bars are.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/math/types.h"

namespace dpl {

/** A field of upright bars of one width, as wide as the gaps between them. The left edge of the field is that of a bar. */
struct PrintedBars {
    double widthMm = 0;
    std::vector<Vec2d> topPx, bottomPx;  // evenly along the upper and the lower edge of the field, from its left to its right
};

/** Width of a field of bars on the cloth. */
constexpr double kBarFieldMm = 30;

/** By name of the frame: the bars that truth.json tells of. Nothing when the scan has none. CorruptData names the file and the frame. */
Result<std::map<std::string, std::vector<PrintedBars>>> readPrintedBars(const std::filesystem::path& scan);

/** Contrast of the bars in `drawn`, of that in the photograph: the share of the photograph's wave of the bars' period that `drawn` has in
 *  its place. 1: the same; 0: no bars; negative: bars where gaps are. Both have 4 bytes a pixel; alpha has no part. nullopt when the
 *  photograph itself does not show them (less than a twentieth of its brightness there, or a bar and a gap in less than two pixels, which
 * pictures cannot tell from coarser ones), or when the field has fewer than 64 pixels. */
std::optional<double> barContrast(std::span<const uint8_t> drawn, std::span<const uint8_t> photograph, uint32_t widthPx, uint32_t heightPx,
                                  const PrintedBars& bars);

}  // namespace dpl
