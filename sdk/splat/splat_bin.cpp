// SPDX-License-Identifier: Apache-2.0
// Depth-ordered tile lists by count, prefix sum and stable scatter. Each worker owns one contiguous range of the sorted splats and one
// array of counters, so every list is in depth order for any number of workers.
#include <algorithm>
#include <cstring>
#include <utility>

#include "sdk/core/log.h"
#include "sdk/splat/buffers.h"

namespace dpl {
namespace {

constexpr size_t kAhead = 16;                        // splats to prefetch ahead
constexpr uint64_t kMaxEntries = uint64_t(1) << 27;  // 512 MiB of tile lists

/** How many of the nearest splats fit into kMaxEntries. */
size_t nearestThatFit(const uint32_t* sorted, const TileBox* boxes, size_t visible) {
    uint64_t total = 0;
    for (size_t i = 0; i < visible; ++i) {
        const TileBox b = boxes[sorted[i]];
        total += uint64_t(b.x1 - b.x0 + 1) * uint64_t(b.y1 - b.y0 + 1);
        if (total > kMaxEntries) {
            log(LogLevel::Warning, "splat tile lists are full: the nearest {} of {} splats are drawn", i, visible);
            return i;
        }
    }
    return visible;
}

}  // namespace

void binIntoTiles(Jobs& jobs, SplatEngine::Buffers& buffers) {
    TileLists& tiles = buffers.tiles;
    tiles.columns = (buffers.widthPx + kTileSizePx - 1) / kTileSizePx;
    tiles.rows = (buffers.heightPx + kTileSizePx - 1) / kTileSizePx;
    const size_t tileCount = size_t(tiles.columns) * tiles.rows;
    size_t visible = buffers.visibleCount;
    const uint32_t workers = uint32_t(std::min<size_t>(jobs.threadCount(), std::max<size_t>(1, visible / 4096)));
    tiles.offset.resize(tileCount + 1);
    uint32_t* counts = buffers.tileCounts.resize(tileCount * workers);
    const uint32_t* sorted = buffers.sorted;
    const TileBox* boxes = buffers.boxes.data();
    const size_t columns = tiles.columns;
    uint64_t total = 0;
    for (const BlockVisible& block : buffers.blocks) total += block.tileEntries;
    if (total > kMaxEntries) visible = nearestThatFit(sorted, boxes, visible);

    // Counting reads the boxes in depth order, so at random addresses; it copies them in sequence for the scatter below.
    TileBox* sortedBoxes = buffers.sortedBoxes.resize(visible);
    const auto rangeOf = [&](size_t worker) { return std::pair(visible * worker / workers, visible * (worker + 1) / workers); };
    jobs.forBlocks(workers, [&](size_t worker, uint32_t) {
        uint32_t* mine = counts + worker * tileCount;
        std::memset(mine, 0, tileCount * sizeof(uint32_t));
        const auto [begin, end] = rangeOf(worker);
        for (size_t i = begin; i < end; ++i) {
            if (i + kAhead < end) __builtin_prefetch(boxes + sorted[i + kAhead]);
            const TileBox box = sortedBoxes[i] = boxes[sorted[i]];
            for (size_t y = box.y0; y <= box.y1; ++y)
                for (size_t x = box.x0; x <= box.x1; ++x) ++mine[y * columns + x];
        }
    });
    uint32_t sum = 0;
    for (size_t tile = 0; tile < tileCount; ++tile) {
        tiles.offset[tile] = sum;
        for (uint32_t w = 0; w < workers; ++w) {
            uint32_t& slot = counts[w * tileCount + tile];
            const uint32_t count = slot;
            slot = sum;
            sum += count;
        }
    }
    tiles.offset[tileCount] = sum;
    if (tiles.entries.size() < sum) tiles.entries.resize(sum);  // never shrinks: vector::resize clears what it adds
    uint32_t* entries = tiles.entries.data();
    jobs.forBlocks(workers, [&](size_t worker, uint32_t) {
        uint32_t* next = counts + worker * tileCount;
        const auto [begin, end] = rangeOf(worker);
        for (size_t i = begin; i < end; ++i) {
            const TileBox box = sortedBoxes[i];
            for (size_t y = box.y0; y <= box.y1; ++y)
                for (size_t x = box.x0; x <= box.x1; ++x) entries[next[y * columns + x]++] = sorted[i];
        }
    });
}

}  // namespace dpl
