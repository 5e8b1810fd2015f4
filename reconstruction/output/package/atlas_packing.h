// SPDX-License-Identifier: Apache-2.0
// Packs shapes of square blocks into a square without overlap.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace dpl {

/** Blocks that a shape takes, row by row. */
struct BlockShape {
    uint32_t columns = 0, rows = 0;
    std::vector<uint8_t> taken;  // columns · rows

    /** Turned by quarterTurns right angles, from the first axis towards the second. */
    BlockShape turned(uint32_t quarterTurns) const;
};

/** Where a shape lies: its first block after it was turned. */
struct BlockPlace {
    uint32_t x = 0, y = 0, quarterTurns = 0;
};

/** Places one a shape in a square of side × side blocks: the largest shape first, each at the first free place of the rows. Nothing: they
 * do not fit so. Deterministic. */
std::optional<std::vector<BlockPlace>> packShapes(std::span<const BlockShape> shapes, uint32_t side);

}  // namespace dpl
