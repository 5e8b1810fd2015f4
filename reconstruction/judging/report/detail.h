// SPDX-License-Identifier: Apache-2.0
// How much of a picture's fine detail is that of the truth (docs/reference/metrics.md).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace dpl {

/** Correlation of fine detail: the luma of both pictures is split into the bands between Gaussians of σ = 1, 2 and 4 px; the result is the
 *  mean of both bands' correlation coefficients over the pixels chosen. 1: the same detail, at any contrast and brightness; 0: unrelated
 *  detail, or none drawn. Blur inside the outline only, so that the outline itself is no detail: pixels whose truth is not opaque are left
 *  out, and so are those within 4 px of one.
 *  `rgba` and `truthRgba` have straight alpha, 4 bytes a pixel; `rgba` is composited on mid grey. `chosen`: a byte a pixel, not 0 where the
 *  pixel counts; empty: all count. nullopt when sizes differ, or when fewer than 64 pixels are left or the truth has no detail there. */
std::optional<double> detailCorrelation(std::span<const uint8_t> rgba, std::span<const uint8_t> truthRgba, uint32_t widthPx,
                                        uint32_t heightPx, std::span<const uint8_t> chosen = {});

}  // namespace dpl
