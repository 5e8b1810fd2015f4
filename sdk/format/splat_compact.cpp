// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/splat_compact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "sdk/format/entropy.h"
#include "sdk/format/plain_bytes.h"
#include "sdk/format/range_code.h"
#include "sdk/format/splat_chunks.h"

namespace dpl {
namespace {

constexpr SplatBits kAllBits;

// Codes of fewer bits, spread evenly over 0..top. Both ends are kept, so that the ends of a chunk's ranges still occur.
constexpr uint32_t narrow(uint32_t code, uint32_t top, uint32_t bits) {
    const uint32_t steps = (1u << bits) - 1;
    return steps >= top ? code : (2 * code * steps + top) / (2 * top);
}
constexpr uint32_t widen(uint32_t code, uint32_t top, uint32_t bits) {
    const uint32_t steps = (1u << bits) - 1;
    return steps >= top ? code : (2 * code * top + steps) / (2 * steps);
}
// φ is periodic: the code after the last is 0.
constexpr uint32_t narrowPhi(uint32_t code, uint32_t bits) {
    return (code + (kPhiSteps >> (bits + 1))) / (kPhiSteps >> bits) & ((1u << bits) - 1);
}
constexpr uint32_t widenPhi(uint32_t code, uint32_t bits) {
    return code * (kPhiSteps >> bits);
}

constexpr uint32_t colourBits(const SplatBits& bits, int channel) {
    return bits.colour - (channel == 0);
}

/** The words of one splat, split into fields. */
struct Fields {
    uint32_t u, v, phi, scale[2], opacity, flags, colour[3];

    Fields() = default;
    Fields(uint32_t place, uint32_t size, uint32_t colourWord)
        : u(place & 2047),
          v(place >> 11 & 2047),
          phi(place >> 22),
          scale{size & 2047, size >> 11 & 2047},
          opacity(size >> 22 & 255),
          flags(size >> 30),
          colour{colourWord & 1023, colourWord >> 10 & 2047, colourWord >> 21} {}
    uint32_t place() const { return u | v << 11 | phi << 22; }
    uint32_t size() const { return scale[0] | scale[1] << 11 | opacity << 22 | flags << 30; }
    uint32_t colourWord() const { return colour[0] | colour[1] << 10 | colour[2] << 21; }
};
Fields fieldsOf(const CodedSplats& coded, size_t i) {
    return {coded.place[i], coded.size[i], coded.colour[i]};
}

Fields narrowed(Fields f, const SplatBits& bits) {
    f.u = narrow(f.u, 2047, bits.uv), f.v = narrow(f.v, 2047, bits.uv), f.phi = narrowPhi(f.phi, bits.phi);
    for (uint32_t& s : f.scale) s = narrow(s, kScaleCodes, bits.scale);
    f.opacity = narrow(f.opacity, 255, bits.opacity);
    for (int k = 0; k < 3; ++k) f.colour[k] = narrow(f.colour[k], kColourCodes[k], colourBits(bits, k));
    return f;
}
Fields widened(Fields f, const SplatBits& bits) {
    f.u = widen(f.u, 2047, bits.uv), f.v = widen(f.v, 2047, bits.uv), f.phi = widenPhi(f.phi, bits.phi);
    for (uint32_t& s : f.scale) s = widen(s, kScaleCodes, bits.scale);
    f.opacity = widen(f.opacity, 255, bits.opacity);
    for (int k = 0; k < 3; ++k) f.colour[k] = widen(f.colour[k], kColourCodes[k], colourBits(bits, k));
    return f;
}

/** The code rounded to `bits` bits such that decoding and coding again does not change it. In a range of a few ulps this may be an end of
 *  the range. */
uint32_t coarse(uint32_t code, const RangeCode& range, uint32_t top, uint32_t bits) {
    uint32_t to = widen(narrow(code, top, bits), top, bits);
    for (int round = 0; round < 4; ++round) {
        const uint32_t again = range.encode(range.decode(to));
        if (again == to) return to;
        to = widen(narrow(again, top, bits), top, bits);
    }
    return code * 2 < top ? 0 : top;
}

// Model: chooses the table of a field by fields that came before. Writer and reader visit fields in the same order. Each name is the first
// table of its kind; tables are chosen by the upper bits of the value named beside it.
enum Table : uint32_t {
    kCountTable = 0,  // number of splats of a triangle; by that of the triangle before
    kFlagTable = 4,   // by the flags of the splat before
    kOpacityTable = 8,
    kScaleTable = 9,    // first scale; by that of the splat before
    kScale2Table = 17,  // second scale; by the first
    kUTable = 25,
    kVTable = 26,  // by u
    kPhiTable = 42,
    kGreenTable = 43,  // by green of the splat before
    kRedTable = 59,    // red and blue: difference from the prediction
    kBlueTable = 60,
    kIndexTable = 61,
    kTables = 62
};
constexpr uint32_t kCountSymbols = 32;  // the last symbol is 31 or more; the remainder follows as bits
/** Number of upper bits of a field that are entropy-coded. The lower ones are stored as they are. */
constexpr uint32_t kFineSymbolBits = 8, kSymbolBits = 6;

constexpr std::array<uint16_t, kTables> kAlphabets = [] {
    std::array<uint16_t, kTables> sizes{};
    for (uint32_t t = 0; t < kTables; ++t) sizes[t] = 1u << kSymbolBits;
    for (uint32_t t = kCountTable; t < kFlagTable; ++t) sizes[t] = kCountSymbols;
    for (uint32_t t = kFlagTable; t < kOpacityTable; ++t) sizes[t] = 4;
    for (const uint32_t t : {kOpacityTable, kRedTable, kBlueTable, kIndexTable}) sizes[t] = 1u << kFineSymbolBits;
    return sizes;
}();

struct Writing {
    EntropyWriter writer{kAlphabets};
    void symbol(uint32_t table, uint32_t& value) { writer.symbol(table, value); }
    void bits(uint32_t& value, uint32_t count) { writer.bits(value, count); }
};
struct Reading {
    EntropyReader& reader;
    void symbol(uint32_t table, uint32_t& value) { value = reader.symbol(table); }
    void bits(uint32_t& value, uint32_t count) { value = reader.bits(count); }
};

/** Codes a value of `bits` bits: the upper `modelled` bits by the table, the others as they are. */
template <uint32_t modelled = kSymbolBits, class Coder>
void field(Coder& coder, uint32_t table, uint32_t bits, uint32_t& value) {
    const uint32_t below = bits > modelled ? bits - modelled : 0;
    uint32_t upper = value >> below, lower = value & ((1u << below) - 1);
    coder.symbol(table, upper);
    if (below) coder.bits(lower, below);
    value = upper << below | lower;
}

/** The upper `count` bits of a value of `bits` bits. */
uint32_t upper(uint32_t value, uint32_t bits, uint32_t count) {
    return bits > count ? value >> (bits - count) : value;
}

/** Colour ranges of a chunk in units of 2⁻¹⁶. Integers make the prediction the same on every machine. */
class ColourScale {
public:
    ColourScale() = default;
    ColourScale(const SplatChunk& chunk, const SplatBits& bits) {
        for (int k = 0; k < 3; ++k) {
            low_[k] = std::llround(double(chunk.dcMin[k]) * 65536), width_[k] = std::llround(double(chunk.dcMax[k]) * 65536) - low_[k];
            top_[k] = std::min(kColourCodes[k], (1u << colourBits(bits, k)) - 1);
            step_[k] = (width_[k] << 16) / top_[k], inverse_[k] = width_[k] > 0 ? (int64_t(top_[k]) << 32) / width_[k] : 0;
        }
    }
    /** The code of channel `to` with the same value as this code of green. */
    int32_t likeGreen(uint32_t green, int to) const {
        const int64_t value = low_[1] + (step_[1] * green >> 16);
        return int32_t((std::clamp<int64_t>(value - low_[to], 0, width_[to]) * inverse_[to] + (int64_t(1) << 31)) >> 32);
    }
    int32_t top(int channel) const { return int32_t(top_[channel]); }

private:
    int64_t low_[3] = {}, width_[3] = {}, step_[3] = {}, inverse_[3] = {};
    uint32_t top_[3] = {};
};

template <class Coder>
class SplatModel {
public:
    SplatModel(Coder& coder, const SplatBits& bits, uint32_t paletteSize)
        : coder_(coder), bits_(bits), indexBits_(paletteSize ? uint32_t(std::bit_width(paletteSize - 1)) : 0) {}

    void count(uint32_t& splats) {
        uint32_t symbol = std::min(splats, kCountSymbols - 1);
        coder_.symbol(kCountTable + lastCount_, symbol);
        if (symbol == kCountSymbols - 1)
            coder_.bits(splats, 32);
        else
            splats = symbol;
        lastCount_ = std::min(splats, 3u);
    }
    void chunk(const SplatChunk& chunk) {
        scale_ = ColourScale(chunk, bits_);
        last_ = {};
        last_.scale[0] = (1u << bits_.scale) / 2, last_.colour[1] = (1u << bits_.colour) / 2;
        asideRed_ = asideBlue_ = 0;
    }
    void splat(Fields& f) {
        coder_.symbol(kFlagTable + last_.flags, f.flags);
        field<kFineSymbolBits>(coder_, kOpacityTable, bits_.opacity, f.opacity);
        field(coder_, kScaleTable + upper(last_.scale[0], bits_.scale, 3), bits_.scale, f.scale[0]);
        field(coder_, kScale2Table + upper(f.scale[0], bits_.scale, 3), bits_.scale, f.scale[1]);
        field(coder_, kUTable, bits_.uv, f.u);
        field(coder_, kVTable + upper(f.u, bits_.uv, 4), bits_.uv, f.v);
        field(coder_, kPhiTable, bits_.phi, f.phi);
        field(coder_, kGreenTable + upper(last_.colour[1], bits_.colour, 4), bits_.colour, f.colour[1]);
        beside(kRedTable, f, 0, asideRed_);
        beside(kBlueTable, f, 2, asideBlue_);
        last_ = f;
    }
    void index(uint32_t& entry) {
        if (indexBits_) field<kFineSymbolBits>(coder_, kIndexTable, indexBits_, entry);
    }

private:
    /** Codes red or blue. Predicts that it differs from green as in the splat before (`aside`). */
    void beside(uint32_t table, Fields& f, int channel, int32_t& aside) {
        const uint32_t bits = colourBits(bits_, channel), mask = (1u << bits) - 1, half = (mask + 1) / 2;
        const int32_t like = scale_.likeGreen(f.colour[1], channel), expected = std::clamp(like + aside, 0, scale_.top(channel));
        uint32_t off = (f.colour[channel] - uint32_t(expected) + half) & mask;
        field<kFineSymbolBits>(coder_, table, bits, off);
        f.colour[channel] = (off - half + uint32_t(expected)) & mask;
        aside = int32_t(f.colour[channel]) - like;
    }

    Coder& coder_;
    SplatBits bits_;
    uint32_t indexBits_, lastCount_ = 0;
    ColourScale scale_;
    Fields last_{};
    int32_t asideRed_ = 0, asideBlue_ = 0;
};

Status checkBits(const SplatBits& bits) {
    const auto in = [](uint32_t value, uint32_t from, uint32_t to) { return value >= from && value <= to; };
    if (in(bits.uv, 1, kAllBits.uv) && in(bits.phi, 1, kAllBits.phi) && in(bits.scale, 1, kAllBits.scale) &&
        in(bits.opacity, 1, kAllBits.opacity) && in(bits.colour, 2, kAllBits.colour))
        return {};
    return fail(Code::CorruptData, "splat fields of {}, {}, {}, {} and {} bits (position, angle, scale, opacity, colour)", bits.uv,
                bits.phi, bits.scale, bits.opacity, bits.colour);
}

size_t rangesAChunk(bool ownSh) {
    return ownSh ? 11 : 8;
}

}  // namespace

void coarsenSplats(CodedSplats& coded, const SplatBits& bits) {
    if (bits == kAllBits) return;
    for (const SplatChunk& c : coded.chunks) {
        const RangeCode scale(c.scaleMinM, c.scaleMaxM, kScaleCodes, true);
        const RangeCode dc[3] = {{c.dcMin[0], c.dcMax[0], kColourCodes[0], false},
                                 {c.dcMin[1], c.dcMax[1], kColourCodes[1], false},
                                 {c.dcMin[2], c.dcMax[2], kColourCodes[2], false}};
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            const Fields whole = fieldsOf(coded, i);
            Fields f = widened(narrowed(whole, bits), bits);
            for (int k = 0; k < 2; ++k) f.scale[k] = coarse(whole.scale[k], scale, kScaleCodes, bits.scale);
            for (int k = 0; k < 3; ++k) f.colour[k] = coarse(whole.colour[k], dc[k], kColourCodes[k], colourBits(bits, k));
            coded.place[i] = f.place(), coded.size[i] = f.size(), coded.colour[i] = f.colourWord();
        }
    }
}

SplatBits neededBits(const CodedSplats& coded) {
    const auto fewest = [&](uint8_t SplatBits::*field, uint8_t from) {
        SplatBits bits;
        for (bits.*field = from; bits.*field < kAllBits.*field; ++(bits.*field)) {
            bool exact = true;
            for (uint32_t i = 0; i < coded.count() && exact; ++i) {
                const Fields f = fieldsOf(coded, i), again = widened(narrowed(f, bits), bits);
                exact = f.place() == again.place() && f.size() == again.size() && f.colourWord() == again.colourWord();
            }
            if (exact) break;
        }
        return bits.*field;
    };
    return {fewest(&SplatBits::uv, 1), fewest(&SplatBits::phi, 1), fewest(&SplatBits::scale, 1), fewest(&SplatBits::opacity, 1),
            fewest(&SplatBits::colour, 2)};
}

void writeCompact(const CodedSplats& coded, const std::vector<uint32_t>& start, SplatStreams<std::vector<uint8_t>>& out) {
    const SplatBits bits = neededBits(coded);
    const bool palette = !coded.shIndex.empty(), ownSh = coded.shDegree > 0 && !palette;
    std::vector<float> ranges;
    if (palette) ranges.assign(coded.chunks[0].shRange, coded.chunks[0].shRange + 3);
    Writing coder;
    SplatModel model(coder, bits, palette ? uint32_t(coded.sh.size() / shEntryBytes(coded.shDegree)) : 0);
    for (size_t t = 0; t + 1 < start.size(); ++t) {
        uint32_t splats = start[t + 1] - start[t];
        model.count(splats);
    }
    for (const SplatChunk& c : coded.chunks) {
        ranges.insert(ranges.end(), {c.scaleMinM, c.scaleMaxM, c.dcMin[0], c.dcMin[1], c.dcMin[2], c.dcMax[0], c.dcMax[1], c.dcMax[2]});
        if (ownSh) ranges.insert(ranges.end(), c.shRange, c.shRange + 3);
        model.chunk(c);
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            Fields f = narrowed(fieldsOf(coded, i), bits);
            model.splat(f);
            uint32_t entry = palette ? coded.shIndex[i] : 0;
            model.index(entry);
        }
    }
    out.ranges = bytesOf(ranges);
    out.coded = coder.writer.finish();
}

Result<std::vector<uint32_t>> readCompact(const SplatStreams<std::span<const uint8_t>>& in, const MeshData& mesh, const SplatHead& head,
                                          CodedSplats& out) {
    const uint32_t n = head.count;
    const SplatBits& bits = *head.bits;
    DPL_RETURN_IF_ERROR(checkBits(bits));
    if (!in.triangleCounts.empty() || !in.chunks.empty() || !in.place.empty() || !in.size.empty() || !in.colour.empty() ||
        !in.shIndex.empty())
        return fail(Code::CorruptData, "splat encoding 3 beside streams of encodings 1 and 2");
    if (n == 0 || in.coded.size() / kMinCompactBytes < n)
        return fail(Code::CorruptData, "{} splats in {} coded bytes; encoding 3 has at least one splat, and {} bytes for each", n,
                    in.coded.size(), kMinCompactBytes);
    DPL_TRY(EntropyReader reader, EntropyReader::open(in.coded, kAlphabets));
    Reading coder{reader};
    SplatModel model(coder, bits, head.paletteSize);
    std::vector<uint32_t> start(mesh.triangles.size() + 1, 0);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        uint32_t splats = 0;
        model.count(splats);
        if (splats > n - start[t]) return fail(Code::CorruptData, "triangles up to {} hold more splats than the {} of the file", t, n);
        start[t + 1] = start[t] + splats;
    }
    if (start.back() != n) return fail(Code::CorruptData, "triangles hold {} splats, the file has {}", start.back(), n);

    const bool ownSh = head.shDegree > 0 && head.paletteSize == 0;
    size_t chunkCount = 0;
    forChunks(mesh, start, [&](uint32_t, uint32_t) { ++chunkCount; });
    const size_t before = head.paletteSize ? 3 : 0;
    if (in.ranges.size() != (before + chunkCount * rangesAChunk(ownSh)) * sizeof(float))
        return fail(Code::CorruptData, "{} bytes of ranges for {} chunks", in.ranges.size(), chunkCount);
    std::vector<float> ranges;
    fill(ranges, in.ranges);
    const float* range = ranges.data() + before;
    out.chunks.reserve(chunkCount);
    out.place.resize(n), out.size.resize(n), out.colour.resize(n);
    if (head.paletteSize) out.shIndex.resize(n);
    Status fits;
    forChunks(mesh, start, [&](uint32_t first, uint32_t count) {
        if (!fits) return;
        SplatChunk& c = out.chunks.emplace_back();
        c.firstSplat = first, c.splatCount = count;
        c.scaleMinM = range[0], c.scaleMaxM = range[1];
        std::copy_n(range + 2, 3, c.dcMin), std::copy_n(range + 5, 3, c.dcMax);
        if (ownSh)
            std::copy_n(range + 8, 3, c.shRange);
        else if (head.paletteSize)
            std::copy_n(ranges.data(), 3, c.shRange);
        range += rangesAChunk(ownSh);
        if (fits = checkRanges(c, out.chunks.size() - 1); !fits) return;
        model.chunk(c);
        for (uint32_t i = first; i < first + count; ++i) {
            Fields f{};
            model.splat(f);
            f = widened(f, bits);
            out.place[i] = f.place(), out.size[i] = f.size(), out.colour[i] = f.colourWord();
            if (head.paletteSize) {
                uint32_t entry = 0;
                model.index(entry);
                out.shIndex[i] = uint16_t(entry);
            }
        }
    });
    DPL_RETURN_IF_ERROR(fits);
    if (!reader.complete()) return fail(Code::CorruptData, "the coded splats do not end where their {} bytes do", in.coded.size());
    return start;
}

}  // namespace dpl
