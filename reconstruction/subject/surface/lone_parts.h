// SPDX-License-Identifier: Apache-2.0
// Parts of a drawn picture that stand free of the person: specks that a splat leaves beside the body.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace dpl {

/** Alpha, of 255, from which a drawn pixel counts as part of something. A fainter one is not seen. */
constexpr uint8_t kShownAlpha = 26;

/** 1 for each pixel of a lone part, else 0. Pixels of `drawn` that touch, by an edge or a corner, are one part. A part is lone when it is
 *  not the largest one and no pixel of it is the person's. drawn, person: one a pixel, row by row, 0 for no. Empty when the sizes differ.
 */
std::vector<uint8_t> loneParts(std::span<const uint8_t> drawn, std::span<const uint8_t> person, uint32_t widthPx, uint32_t heightPx);

}  // namespace dpl
