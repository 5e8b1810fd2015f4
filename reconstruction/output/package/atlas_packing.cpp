// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/atlas_packing.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace dpl {
namespace {

constexpr uint32_t kBits = 64;

/** Rows of bits, so that a whole row of a shape is tested in a few words. */
class Sheet {
public:
    explicit Sheet(uint32_t side) : side_(side), words_(side / kBits + 2), bits_(size_t(words_) * side, 0) {}

    struct Shape {
        uint32_t columns, rows, words;
        std::vector<uint64_t> bits;
    };
    static Shape shapeOf(const BlockShape& from) {
        Shape out{from.columns, from.rows, (from.columns + kBits - 1) / kBits, {}};
        out.bits.assign(size_t(out.words) * out.rows, 0);
        for (uint32_t y = 0; y < from.rows; ++y)
            for (uint32_t x = 0; x < from.columns; ++x)
                if (from.taken[size_t(y) * from.columns + x]) out.bits[size_t(y) * out.words + x / kBits] |= uint64_t(1) << (x % kBits);
        return out;
    }

    bool free(const Shape& s, uint32_t x, uint32_t y) const {
        const uint32_t shift = x % kBits;
        for (uint32_t row = 0; row < s.rows; ++row) {
            const uint64_t* own = s.bits.data() + size_t(row) * s.words;
            const uint64_t* sheet = bits_.data() + size_t(y + row) * words_ + x / kBits;
            for (uint32_t w = 0; w < s.words; ++w) {
                if (sheet[w] & (own[w] << shift)) return false;
                if (shift && (sheet[w + 1] & (own[w] >> (kBits - shift)))) return false;
            }
        }
        return true;
    }
    void take(const Shape& s, uint32_t x, uint32_t y) {
        const uint32_t shift = x % kBits;
        for (uint32_t row = 0; row < s.rows; ++row) {
            const uint64_t* own = s.bits.data() + size_t(row) * s.words;
            uint64_t* sheet = bits_.data() + size_t(y + row) * words_ + x / kBits;
            for (uint32_t w = 0; w < s.words; ++w) {
                sheet[w] |= own[w] << shift;
                if (shift) sheet[w + 1] |= own[w] >> (kBits - shift);
            }
        }
    }
    /** The first free place in the order of rows that ends below `most`. What was not free stays so, and the search for a shape goes on
     * where it ended for the last equal one. */
    std::optional<BlockPlace> find(const Shape& s, uint32_t most) {
        if (s.columns > side_) return std::nullopt;
        BlockPlace& from = searched_[{s.columns, s.bits}];
        for (; from.y + s.rows <= most; ++from.y, from.x = 0)
            for (; from.x + s.columns <= side_; ++from.x)
                if (free(s, from.x, from.y)) return from;
        return std::nullopt;
    }

private:
    uint32_t side_, words_;  // two words more than a row has, so that shifted reads stay within
    std::vector<uint64_t> bits_;
    std::map<std::pair<uint32_t, std::vector<uint64_t>>, BlockPlace> searched_;  // columns and bits of a shape
};

}  // namespace

BlockShape BlockShape::turned(uint32_t quarterTurns) const {
    BlockShape out = *this;
    for (uint32_t turn = 0; turn < quarterTurns % 4; ++turn) {
        BlockShape next{out.rows, out.columns, std::vector<uint8_t>(out.taken.size())};
        for (uint32_t y = 0; y < out.rows; ++y)
            for (uint32_t x = 0; x < out.columns; ++x)
                next.taken[size_t(x) * next.columns + (out.rows - 1 - y)] = out.taken[size_t(y) * out.columns + x];
        out = std::move(next);
    }
    return out;
}

std::optional<std::vector<BlockPlace>> packShapes(std::span<const BlockShape> shapes, uint32_t side) {
    std::vector<uint32_t> order(shapes.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto size = [&](uint32_t s) { return size_t(shapes[s].columns) * shapes[s].rows; };
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return size(a) > size(b); });
    Sheet sheet(side);
    std::vector<BlockPlace> places(shapes.size());
    for (const uint32_t s : order) {
        std::optional<BlockPlace> best;
        uint32_t most = side;
        Sheet::Shape bestShape;
        for (uint32_t turns = 0; turns < 4; ++turns) {
            Sheet::Shape shape = Sheet::shapeOf(shapes[s].turned(turns));
            const auto place = sheet.find(shape, most);
            if (!place) continue;
            best = BlockPlace{place->x, place->y, turns};
            most = place->y + shape.rows - 1;  // another turn must end lower
            bestShape = std::move(shape);
        }
        if (!best) return std::nullopt;
        sheet.take(bestShape, best->x, best->y);
        places[s] = *best;
    }
    return places;
}

}  // namespace dpl
