// SPDX-License-Identifier: Apache-2.0
// Stable LSD radix sort of the visible splats by view depth, near first; ties keep splat order.
//
// Positive floats order like their bits, so the key is bits(z) − bits(nearest z). An avatar three metres away needs two digits of twelve
// bits. Each worker owns one contiguous range. A stable sort has only one result, so the order does not depend on the number of workers.
#include <algorithm>
#include <bit>

#include "sdk/splat/buffers.h"

namespace dpl {
namespace {

constexpr uint32_t kDigitBits = 12, kBins = 1u << kDigitBits;

/** Turns counts per (bin, worker) into start positions, bin by bin, so that the scatter is stable. */
void exclusiveScan(std::vector<uint32_t>& histogram, uint32_t workers) {
    uint32_t sum = 0;
    for (uint32_t bin = 0; bin < kBins; ++bin)
        for (uint32_t w = 0; w < workers; ++w) {
            uint32_t& slot = histogram[size_t(w) * kBins + bin];
            const uint32_t count = slot;
            slot = sum;
            sum += count;
        }
}

}  // namespace

void sortByDepth(Jobs& jobs, SplatEngine::Buffers& buffers) {
    uint32_t minKey = 0xffffffffu, maxKey = 0, visible = 0;
    for (const BlockVisible& block : buffers.blocks) {
        visible += block.count;
        minKey = std::min(minKey, block.minKey), maxKey = std::max(maxKey, block.maxKey);
    }
    buffers.visibleCount = visible;
    buffers.sortedFrame = true;
    uint32_t* keys[2] = {buffers.keys[0].data(), buffers.keys[1].resize(visible)};
    uint32_t* values[2] = {buffers.values[0].data(), buffers.values[1].resize(visible)};
    buffers.sorted = values[1];
    if (visible == 0) return;

    const uint32_t bits = uint32_t(std::bit_width(maxKey - minKey));
    const uint32_t passes = std::max(1u, (bits + kDigitBits - 1) / kDigitBits);
    const uint32_t workers = std::min(jobs.threadCount(), std::max(1u, visible / 8192));  // small frames: one worker
    buffers.histogram.resize(size_t(workers) * kBins);

    // The first pass reads the visible splats of each block of projection, later passes one range each; both in splat order.
    const auto forPieces = [&](uint32_t pass, uint32_t worker, auto&& body) {
        if (pass == 0) {
            const size_t first = buffers.blocks.size() * worker / workers, last = buffers.blocks.size() * (worker + 1) / workers;
            for (size_t b = first; b < last; ++b) body(b * kProjectBlock, b * kProjectBlock + buffers.blocks[b].count);
        } else {
            body(size_t(visible) * worker / workers, size_t(visible) * (worker + 1) / workers);
        }
    };
    for (uint32_t pass = 0; pass < passes; ++pass) {
        const uint32_t shift = pass * kDigitBits;
        const uint32_t *keysIn = keys[pass & 1], *valuesIn = values[pass & 1];
        uint32_t *keysOut = keys[(pass + 1) & 1], *valuesOut = values[(pass + 1) & 1];
        jobs.forBlocks(workers, [&](size_t worker, uint32_t) {
            uint32_t* counts = buffers.histogram.data() + worker * kBins;
            std::fill_n(counts, kBins, 0u);
            forPieces(pass, uint32_t(worker), [&](size_t begin, size_t end) {
                for (size_t i = begin; i < end; ++i) ++counts[((keysIn[i] - minKey) >> shift) & (kBins - 1)];
            });
        });
        exclusiveScan(buffers.histogram, workers);
        jobs.forBlocks(workers, [&](size_t worker, uint32_t) {
            uint32_t* next = buffers.histogram.data() + worker * kBins;
            forPieces(pass, uint32_t(worker), [&](size_t begin, size_t end) {
                for (size_t i = begin; i < end; ++i) {
                    const uint32_t key = keysIn[i], slot = next[((key - minKey) >> shift) & (kBins - 1)]++;
                    keysOut[slot] = key, valuesOut[slot] = valuesIn[i];
                }
            });
        });
    }
    buffers.sorted = values[passes & 1];
}

}  // namespace dpl
