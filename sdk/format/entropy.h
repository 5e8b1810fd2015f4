// SPDX-License-Identifier: Apache-2.0
// Entropy coder of splat encoding 3 and correctives encoding 2: range asymmetric numeral systems (Duda 2013, arXiv:1311.2540) with a fixed
// table of frequencies per context, and uncoded bits in a separate stream. Two states alternate, so that a reader can overlap two symbols.
//
//   bytes:  u32 words │ u32 state 0 │ u32 state 1 │ tables │ words, u16 each │ raw bits, lowest first
//   table:  frequencies of its symbols as LEB128, sum 4096; after a frequency of 0, the number of further zeros
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

constexpr uint32_t kEntropyBits = 12;         // frequencies sum to 2^12
constexpr uint32_t kMaxEntropySymbols = 256;  // per table

/** Collects symbols and bits; finish() counts the symbols into tables and codes them. Up to 8 bytes of memory per symbol. */
class EntropyWriter {
public:
    /** alphabets: the number of symbols of each table, 1 to 256. */
    explicit EntropyWriter(std::span<const uint16_t> alphabets);
    void symbol(uint32_t table, uint32_t symbol) { symbols_.push_back({uint16_t(table), uint16_t(symbol)}); }
    /** Appends the lowest `count` bits (≤ 32) of `value`; the others must be 0. */
    void bits(uint32_t value, uint32_t count);
    std::vector<uint8_t> finish();

private:
    struct Symbol {
        uint16_t table, symbol;
    };
    std::vector<uint16_t> alphabets_;
    std::vector<Symbol> symbols_;
    std::vector<uint8_t> raw_;
    uint64_t pending_ = 0;
    uint32_t pendingBits_ = 0;
};

/** Reads what an EntropyWriter with the same alphabets wrote, in the same order. Borrows the bytes. Past the end it reads zeros: damaged
 *  bytes give wrong values but never a crash. The caller must check the values, and complete() at the end. */
class EntropyReader {
public:
    /** CorruptData: lengths that do not fit, or a table that does not sum to 4096. */
    static Result<EntropyReader> open(std::span<const uint8_t> bytes, std::span<const uint16_t> alphabets);

    uint32_t symbol(uint32_t table) {
        const uint32_t slot = state_[turn_] & ((1u << kEntropyBits) - 1);
        const uint8_t symbol = symbolOf_[(size_t(table) << kEntropyBits) + slot];
        const Share& share = shares_[size_t(table) * kMaxEntropySymbols + symbol];
        uint32_t x = share.frequency * (state_[turn_] >> kEntropyBits) + slot - share.start;
        if (x < kLowest) {
            uint16_t word = 0;
            if (nextWord_ < words_.size()) std::memcpy(&word, words_.data() + nextWord_, 2);
            nextWord_ += 2;
            x = x << 16 | word;
        }
        state_[turn_] = x, turn_ ^= 1;
        return symbol;
    }
    /** Reads `count` bits, ≤ 32. */
    uint32_t bits(uint32_t count) {
        const size_t at = size_t(nextBit_ >> 3);
        uint64_t window = 0;
        if (at + 8 <= raw_.size())
            std::memcpy(&window, raw_.data() + at, 8);
        else if (at < raw_.size())
            std::memcpy(&window, raw_.data() + at, raw_.size() - at);
        window >>= nextBit_ & 7;
        nextBit_ += count;
        return uint32_t(window & ((1ull << count) - 1));
    }
    /** True if all bytes were read, none past the end, and both states are back at the writer's initial value. */
    bool complete() const;

    static constexpr uint32_t kLowest = 1u << 16;  // smallest value of a state between symbols

private:
    struct Share {
        uint16_t frequency = 0, start = 0;
    };
    std::vector<uint8_t> symbolOf_;  // table × 4096 slots
    std::vector<Share> shares_;      // table × 256 symbols
    std::span<const uint8_t> words_, raw_;
    size_t nextWord_ = 0;  // bytes
    uint64_t nextBit_ = 0;
    uint32_t state_[2] = {kLowest, kLowest}, turn_ = 0;
};

}  // namespace dpl
