// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/entropy.h"

#include <algorithm>
#include <numeric>

namespace dpl {
namespace {

constexpr uint32_t kWhole = 1u << kEntropyBits;
constexpr size_t kHeadBytes = 12;

void appendNumber(std::vector<uint8_t>& out, uint32_t value) {  // LEB128
    for (; value >= 0x80; value >>= 7) out.push_back(uint8_t(value | 0x80));
    out.push_back(uint8_t(value));
}

void appendU32(std::vector<uint8_t>& out, uint32_t value) {
    for (int k = 0; k < 4; ++k) out.push_back(uint8_t(value >> 8 * k));
}

uint32_t u32At(std::span<const uint8_t> bytes, size_t at) {
    return uint32_t(bytes[at]) | uint32_t(bytes[at + 1]) << 8 | uint32_t(bytes[at + 2]) << 16 | uint32_t(bytes[at + 3]) << 24;
}

/** Scales counts to shares that sum to 4096. A symbol that occurs has a share of at least 1. An unused table gives all to symbol 0. */
std::vector<uint32_t> sharesOf(std::span<const uint32_t> counts) {
    std::vector<uint32_t> shares(counts.size(), 0);
    const uint64_t total = std::accumulate(counts.begin(), counts.end(), uint64_t(0));
    if (total == 0) return shares[0] = kWhole, shares;
    for (size_t s = 0; s < counts.size(); ++s)
        if (counts[s]) shares[s] = std::max(1u, uint32_t((uint64_t(counts[s]) * kWhole + total / 2) / total));
    for (int64_t off = int64_t(std::accumulate(shares.begin(), shares.end(), 0u)) - kWhole; off != 0;) {
        uint32_t& largest = *std::max_element(shares.begin(), shares.end());  // ≥ 16, because at most 256 symbols share 4096
        off > 0 ? (--largest, --off) : (++largest, ++off);
    }
    return shares;
}

}  // namespace

EntropyWriter::EntropyWriter(std::span<const uint16_t> alphabets) : alphabets_(alphabets.begin(), alphabets.end()) {}

void EntropyWriter::bits(uint32_t value, uint32_t count) {
    pending_ |= uint64_t(value) << pendingBits_, pendingBits_ += count;
    for (; pendingBits_ >= 8; pendingBits_ -= 8, pending_ >>= 8) raw_.push_back(uint8_t(pending_));
}

std::vector<uint8_t> EntropyWriter::finish() {
    std::vector<std::vector<uint32_t>> counts;
    for (const uint16_t size : alphabets_) counts.emplace_back(size, 0u);
    for (const Symbol& s : symbols_) ++counts[s.table][s.symbol];
    std::vector<uint8_t> tables;
    std::vector<std::vector<uint32_t>> starts;
    for (auto& table : counts) {
        table = sharesOf(table);
        starts.emplace_back(table.size(), 0u);
        std::exclusive_scan(table.begin(), table.end(), starts.back().begin(), 0u);
        for (size_t s = 0; s < table.size(); ++s) {
            appendNumber(tables, table[s]);
            if (table[s]) continue;
            size_t end = s + 1;
            while (end < table.size() && !table[end]) ++end;
            appendNumber(tables, uint32_t(end - s - 1));
            s = end - 1;
        }
    }
    uint32_t state[2] = {EntropyReader::kLowest, EntropyReader::kLowest};
    std::vector<uint16_t> words;  // in reverse order: the coder writes backwards
    for (size_t i = symbols_.size(); i-- > 0;) {
        const uint32_t share = counts[symbols_[i].table][symbols_[i].symbol];
        uint32_t& x = state[i & 1];
        if (x >= (uint64_t(EntropyReader::kLowest >> kEntropyBits) << 16) * share) words.push_back(uint16_t(x)), x >>= 16;
        x = (x / share << kEntropyBits) + x % share + starts[symbols_[i].table][symbols_[i].symbol];
    }
    std::vector<uint8_t> out;
    appendU32(out, uint32_t(words.size())), appendU32(out, state[0]), appendU32(out, state[1]);
    out.insert(out.end(), tables.begin(), tables.end());
    for (size_t i = words.size(); i-- > 0;) out.push_back(uint8_t(words[i])), out.push_back(uint8_t(words[i] >> 8));
    if (pendingBits_ > 0) raw_.push_back(uint8_t(pending_));
    out.insert(out.end(), raw_.begin(), raw_.end());
    return out;
}

Result<EntropyReader> EntropyReader::open(std::span<const uint8_t> bytes, std::span<const uint16_t> alphabets) {
    if (bytes.size() < kHeadBytes)
        return fail(Code::CorruptData, "{} bytes of coded splats, the head alone has {}", bytes.size(), kHeadBytes);
    EntropyReader r;
    const uint64_t words = u32At(bytes, 0);
    for (int k = 0; k < 2; ++k)
        if (r.state_[k] = u32At(bytes, 4 + 4 * k); r.state_[k] < kLowest)
            return fail(Code::CorruptData, "a state of the coded splats is {}, at least {} is possible", r.state_[k], kLowest);
    size_t at = kHeadBytes;
    const auto number = [&]() -> uint32_t {  // LEB128 of at most two bytes; a longer one gives a value that the caller refuses
        uint32_t value = 0;
        for (uint32_t shift = 0; at < bytes.size() && shift < 21; shift += 7) {
            const uint8_t byte = bytes[at++];
            value |= uint32_t(byte & 0x7f) << shift;
            if (!(byte & 0x80)) return value;
        }
        return ~0u;
    };
    r.symbolOf_.resize(alphabets.size() << kEntropyBits);
    r.shares_.resize(alphabets.size() * kMaxEntropySymbols);
    for (size_t t = 0; t < alphabets.size(); ++t) {
        uint32_t sum = 0;
        for (uint32_t s = 0; s < alphabets[t]; ++s) {
            const uint32_t share = number();
            if (share > kWhole - sum)
                return fail(Code::CorruptData, "frequencies of table {} of the coded splats are cut off or sum to more than {}", t, kWhole);
            if (share == 0) {
                const uint32_t zeros = number();
                if (zeros > alphabets[t] - 1 - s)
                    return fail(Code::CorruptData, "table {} of the coded splats has more than {} symbols", t, alphabets[t]);
                s += zeros;
                continue;
            }
            r.shares_[t * kMaxEntropySymbols + s] = {uint16_t(share), uint16_t(sum)};
            std::fill_n(r.symbolOf_.begin() + ptrdiff_t((t << kEntropyBits) + sum), share, uint8_t(s));
            sum += share;
        }
        if (sum != kWhole)
            return fail(Code::CorruptData, "frequencies of table {} of the coded splats sum to {} instead of {}", t, sum, kWhole);
    }
    if (words * 2 > bytes.size() - at)
        return fail(Code::CorruptData, "{} words of coded splats, {} bytes are left", words, bytes.size() - at);
    r.words_ = bytes.subspan(at, size_t(words) * 2), r.raw_ = bytes.subspan(at + size_t(words) * 2);
    return r;
}

bool EntropyReader::complete() const {
    if (nextWord_ != words_.size() || state_[0] != kLowest || state_[1] != kLowest || (nextBit_ + 7) / 8 != raw_.size()) return false;
    return nextBit_ % 8 == 0 || raw_.back() >> (nextBit_ % 8) == 0;
}

}  // namespace dpl
