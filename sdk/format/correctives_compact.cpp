// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/correctives_compact.h"

#include <algorithm>
#include <array>
#include <bit>

#include "sdk/format/entropy.h"
#include "sdk/format/plain_bytes.h"

namespace dpl {
namespace {

// First tables of each kind, 256 symbols a table. Rank: position of a vertex's node among the recently used ones, one table per slot.
// Weights 1 to 3: the second and third have one table for each value of the upper three bits of the weight before. Node: upper byte of x,
// y, z, brightness, one table each.
enum Table : uint32_t { kRankTable = 0, kWeightTable = 4, kWeight2Table = 5, kWeight3Table = 13, kNodeTable = 21, kTables = 25 };
constexpr uint32_t kUnknown = 255;  // rank of a node that is not among the last 255; its index follows as bits
constexpr std::array<uint16_t, kTables> kAlphabets = [] {
    std::array<uint16_t, kTables> sizes{};
    sizes.fill(256);
    return sizes;
}();

/** The recently used nodes, latest first. Vertices that are neighbours in the file mostly use the same nodes. */
class Recent {
public:
    /** Rank of the node, or kUnknown. Moves it to the front. */
    uint32_t use(uint16_t node) {
        const uint32_t rank = uint32_t(std::find(nodes_.begin(), nodes_.begin() + count_, node) - nodes_.begin());
        const bool known = rank < count_;
        moveToFront(known ? rank : add(), node);
        return known ? rank : kUnknown;
    }
    /** Node of this rank (< count()). Moves it to the front. */
    uint16_t useRank(uint32_t rank) {
        const uint16_t node = nodes_[rank];
        moveToFront(rank, node);
        return node;
    }
    uint32_t count() const { return count_; }

private:
    uint32_t add() { return count_ < kUnknown ? count_++ : kUnknown - 1; }  // a full list drops the oldest
    void moveToFront(uint32_t rank, uint16_t node) {
        std::copy_backward(nodes_.begin(), nodes_.begin() + rank, nodes_.begin() + rank + 1);
        nodes_[0] = node;
    }
    std::array<uint16_t, kUnknown> nodes_{};
    uint32_t count_ = 0;
};

uint32_t nodeBits(uint32_t nodeCount) {
    return uint32_t(std::bit_width(nodeCount - 1));
}

}  // namespace

std::vector<uint8_t> compactCorrectives(const CorrectiveStreams<std::vector<uint8_t>>& streams, uint32_t nodeCount) {
    std::vector<uint16_t> indices, values;
    fill(indices, streams.nodeIndices), fill(values, streams.nodes);
    EntropyWriter writer(kAlphabets);
    Recent recent;
    for (size_t i = 0; i < indices.size(); ++i) {
        const uint32_t rank = recent.use(indices[i]);
        writer.symbol(kRankTable + uint32_t(i % 4), rank);
        if (rank == kUnknown) writer.bits(indices[i], nodeBits(nodeCount));
    }
    for (size_t v = 0; v + 3 < streams.nodeWeights.size(); v += 4) {
        const uint8_t* w = &streams.nodeWeights[v];
        writer.symbol(kWeightTable, w[0]), writer.symbol(kWeight2Table + (w[0] >> 5), w[1]),
            writer.symbol(kWeight3Table + (w[1] >> 5), w[2]);  // the fourth is the rest to 255
    }
    for (size_t i = 0; i < values.size(); ++i) {
        const uint32_t value = uint16_t(values[i] + 0x8000u);
        writer.symbol(kNodeTable + uint32_t(i % 4), value >> 8), writer.bits(value & 255, 8);
    }
    return writer.finish();
}

Result<CorrectiveStreams<std::vector<uint8_t>>> expandCorrectives(std::span<const uint8_t> coded, uint32_t columnCount, uint32_t nodeCount,
                                                                  size_t vertexCount) {
    const size_t count = size_t(columnCount) * nodeCount * 4;
    // The lower byte of each value is stored uncoded, so fewer bytes cannot be enough.
    if (nodeCount == 0 || coded.size() < count)
        return fail(Code::CorruptData, "{} coded bytes do not hold {} nodes of {} modes", coded.size(), nodeCount, columnCount);
    DPL_TRY(EntropyReader reader, EntropyReader::open(coded, kAlphabets));
    CorrectiveStreams<std::vector<uint8_t>> out;
    std::vector<uint16_t> indices(vertexCount * 4), values(count);
    Recent recent;
    for (size_t i = 0; i < indices.size(); ++i) {
        const uint32_t rank = reader.symbol(kRankTable + uint32_t(i % 4));
        if (rank == kUnknown) {
            indices[i] = uint16_t(reader.bits(nodeBits(nodeCount)));
            if (recent.use(indices[i]) != kUnknown)
                return fail(Code::CorruptData, "node {} of vertex {} is stored as new, but it was used recently", indices[i], i / 4);
        } else if (rank < recent.count()) {
            indices[i] = recent.useRank(rank);
        } else {
            return fail(Code::CorruptData, "vertex {} refers to a recent node that does not exist", i / 4);
        }
    }
    out.nodeWeights.resize(vertexCount * 4);
    for (size_t v = 0; v < out.nodeWeights.size(); v += 4) {
        uint8_t* w = &out.nodeWeights[v];
        w[0] = uint8_t(reader.symbol(kWeightTable)), w[1] = uint8_t(reader.symbol(kWeight2Table + (w[0] >> 5))),
        w[2] = uint8_t(reader.symbol(kWeight3Table + (w[1] >> 5)));
        if (w[0] + w[1] + w[2] > 255) return fail(Code::CorruptData, "weights of the nodes of vertex {} sum to more than 255", v / 4);
        w[3] = uint8_t(255 - w[0] - w[1] - w[2]);
    }
    for (size_t i = 0; i < values.size(); ++i) {
        const uint32_t upper = reader.symbol(kNodeTable + uint32_t(i % 4));
        values[i] = uint16_t((upper << 8 | reader.bits(8)) - 0x8000u);
    }
    if (!reader.complete()) return fail(Code::CorruptData, "the coded correctives do not end where their {} bytes do", coded.size());
    out.nodeIndices = bytesOf(indices), out.nodes = bytesOf(values);
    return out;
}

}  // namespace dpl
