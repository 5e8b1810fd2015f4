// SPDX-License-Identifier: Apache-2.0
// Splat encoding 3 and correctives encoding 2: the entropy coder, bits of fields, and the same words after loading as from other encodings.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/entropy.h"
#include "sdk/format/splat_codec.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/tube_avatar.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

constexpr SplatBits kBits[] = {{}, {8, 7, 8, 6, 8}, {6, 5, 6, 4, 7}, {1, 1, 1, 1, 2}, {11, 10, 5, 8, 11}, {10, 9, 10, 7, 10}};

AvatarData sorted(AvatarData a) {
    sortSplats(a);
    return a;
}
AvatarData tube(uint32_t degree = 1) {
    return sorted(makeTube({.splatsPerTriangle = 6, .shDegree = degree}));
}

CodedSplats wordsOf(std::span<const uint8_t> file) {
    auto read = readCodedAvatar(file);
    EXPECT_TRUE(read) << (read ? "" : read.error().message);
    return read ? std::move(read->splats) : CodedSplats();
}

bool sameWords(const CodedSplats& a, const CodedSplats& b) {
    return a.place == b.place && a.size == b.size && a.colour == b.colour && a.shIndex == b.shIndex && a.sh == b.sh &&
           a.parents == b.parents && a.parent == b.parent && a.chunks.size() == b.chunks.size() &&
           std::memcmp(a.chunks.data(), b.chunks.data(), a.chunks.size() * sizeof(SplatChunk)) == 0;
}

TEST(Entropy, whatIsWrittenIsReadAndCostsAboutItsEntropy) {
    const uint16_t alphabets[] = {256, 1, 7, 64, 5};
    std::mt19937 random(3);
    std::geometric_distribution<uint32_t> falling(0.2);
    for (const size_t count : {size_t(0), size_t(1), size_t(2), size_t(1000), size_t(200001)}) {
        std::vector<std::array<uint32_t, 4>> items;  // table, symbol, bits, number of bits
        double entropy = 0;
        EntropyWriter writer(alphabets);
        for (size_t i = 0; i < count; ++i) {
            const uint32_t table = random() % 4, symbol = table == 0 ? std::min(255u, falling(random)) : random() % alphabets[table],
                           bits = random() % 33;
            const uint32_t value = bits == 32 ? uint32_t(random()) : uint32_t(random()) & ((1u << bits) - 1);
            items.push_back({table, symbol, value, bits});
            writer.symbol(table, symbol), writer.bits(value, bits);
            entropy += bits + (table == 0 ? -std::log2(0.2) - symbol * std::log2(0.8) : std::log2(double(alphabets[table])));
        }
        const std::vector<uint8_t> bytes = writer.finish();
        if (count > 100000) {
            EXPECT_LT(double(bytes.size()) * 8, entropy * 1.005 + 4000);
        }
        auto reader = EntropyReader::open(bytes, alphabets);
        ASSERT_TRUE(reader) << reader.error().message;
        for (const auto& [table, symbol, value, bits] : items) {
            ASSERT_EQ(reader->symbol(table), symbol);
            ASSERT_EQ(reader->bits(bits), value);
        }
        EXPECT_TRUE(reader->complete());
        // complete() notices a symbol or bit too few or too many.
        auto fewer = EntropyReader::open(bytes, alphabets);
        EXPECT_EQ(fewer->complete(), count == 0);
        (void)reader->bits(8);
        EXPECT_FALSE(reader->complete());
        for (int k = 0; k < 100; ++k)
            (void)reader->symbol(uint32_t(k) % 5), (void)reader->bits(32);  // reads zeros past the end; must not crash
    }
}

TEST(Entropy, tablesAndLengthsThatCannotBeAreRefused) {
    const uint16_t alphabets[] = {4};
    EntropyWriter writer(alphabets);
    for (uint32_t i = 0; i < 100; ++i) writer.symbol(0, i % 3);
    const std::vector<uint8_t> good = writer.finish();  // 12 bytes of head, then frequencies 1366, 1365, 1365, then one zero
    ASSERT_TRUE(EntropyReader::open(good, alphabets));
    for (size_t size = 0; size < good.size(); ++size) EXPECT_FALSE(EntropyReader::open(std::span(good).first(size), alphabets)) << size;
    const auto refused = [&](size_t at, uint8_t value) {
        std::vector<uint8_t> bad = good;
        bad[at] = value;
        return !EntropyReader::open(bad, alphabets);
    };
    EXPECT_TRUE(refused(2, 1)) << "words past the end";
    EXPECT_TRUE(refused(3, 0x80)) << "2^31 words";
    EXPECT_TRUE(refused(12, good[12] ^ 1)) << "frequencies that sum to another number";
    EXPECT_TRUE(refused(13, 0x7f)) << "a frequency above the whole";
    std::vector<uint8_t> bad = good;
    bad[6] = bad[7] = 0;
    EXPECT_FALSE(EntropyReader::open(bad, alphabets)) << "a state below the lowest";
}

TEST(CompactSplats, loadToTheSameWordsAsAFileOfWords) {
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        for (const bool palette : {false, true}) {
            AvatarData a = tube(degree);
            if (palette)
                for (size_t k = 0, stride = shCoefficientCount(degree) * 3; k < a.splats.sh.size(); ++k)
                    if (k % stride >= 3) a.splats.sh[k] = a.splats.sh[k % (100 * stride)];
            for (const SplatBits& bits : kBits) {
                const auto plain = writeAvatar(a, {.shPalette = palette, .bits = bits}),
                           compact = writeAvatar(a, {.shPalette = palette, .compact = true, .bits = bits});
                ASSERT_TRUE(plain && compact);
                EXPECT_LE(compact->size(), plain->size());
                const AvatarInfo info = *inspectAvatar(*compact);
                const bool tooFew = bits.uv == 1;
                if (bits != SplatBits()) {
                    EXPECT_EQ(info.splatEncoding, tooFew ? (palette && degree ? 2u : 1u) : 3u)
                        << "less than 4 bytes a splat would be an invitation to exhaust memory";
                }
                EXPECT_TRUE(sameWords(wordsOf(*plain), wordsOf(*compact))) << "degree " << degree << ", " << int(bits.uv) << " bits";
                if (info.splatEncoding != 3) continue;
                EXPECT_EQ(info.bits, bits);
                EXPECT_EQ(info.meshBytes + info.splatBytes + info.shBytes + info.correctiveBytes + info.clipBytes + info.skinBytes +
                              info.jsonBytes + info.otherBytes,
                          compact->size());
                EXPECT_EQ(info.shPaletteSize > 0, palette && degree > 0);
                // Reading and writing again gives the same bytes, also with fewer bits.
                const AvatarData back = *readAvatar(*compact);
                EXPECT_TRUE(*writeAvatar(back, {.shPalette = palette, .compact = true, .bits = bits}) == *compact);
                EXPECT_TRUE(*writeAvatar(back, {.shPalette = palette, .compact = true}) == *compact);
            }
        }
    }
}

TEST(CompactSplats, pinnedBytesStillReadAndAreWrittenAgain) {
    const auto bytes = readFile(sourceFolder() / "tests/unit/format/pinned/splats_encoding3.glb");
    ASSERT_TRUE(bytes);
    const CodedSplats s = wordsOf(*bytes);
    ASSERT_EQ(inspectAvatar(*bytes)->splatEncoding, 3u);
    const auto hash = [](auto& words) {
        uint64_t h = 14695981039346656037ull;
        for (const auto w : words) h = (h ^ uint64_t(w)) * 1099511628211ull;
        return h;
    };  // FNV
    EXPECT_EQ(hash(s.place), 17513995115256210650ull);
    EXPECT_EQ(hash(s.size), 16501676253954177683ull);
    EXPECT_EQ(hash(s.colour), 16171394449161400075ull);
    EXPECT_EQ(hash(s.shIndex), 9023295318735849672ull);
    EXPECT_EQ(hash(s.parents), 12887118480896278798ull);
    EXPECT_TRUE(*writeAvatar(*readAvatar(*bytes), {.draco = false, .shPalette = true, .compact = true}) == *bytes);
}

TEST(CompactSplats, roundingStaysWithinHalfAStep) {
    const AvatarData a = tube();
    const CodedSplats whole = *codeSplats(a.mesh, a.splats);
    for (const SplatBits& bits : kBits) {
        CodedSplats coarse = whole;
        coarsenSplats(coarse, bits);
        EXPECT_EQ(neededBits(coarse), bits);
        const auto farthest = [&](auto&& field) {
            int far = 0;
            for (uint32_t i = 0; i < whole.count(); ++i) far = std::max(far, std::abs(field(whole, i) - field(coarse, i)));
            return far;
        };
        const auto half = [](int top, int bits) { return ((1 << bits) - 1 >= top) ? 0.0 : top / double((1 << bits) - 1) / 2 + 0.5; };
        EXPECT_LE(farthest([](auto& s, uint32_t i) { return int(s.place[i] & 2047); }), half(2047, bits.uv));
        EXPECT_LE(farthest([](auto& s, uint32_t i) { return int(s.place[i] >> 11 & 2047); }), half(2047, bits.uv));
        EXPECT_LE(farthest([](auto& s, uint32_t i) { return int(s.size[i] & 2047); }), half(2047, bits.scale));
        EXPECT_LE(farthest([](auto& s, uint32_t i) { return int(s.size[i] >> 11 & 2047); }), half(2047, bits.scale));
        EXPECT_LE(farthest([](auto& s, uint32_t i) { return int(s.size[i] >> 22 & 255); }), half(255, bits.opacity));
        EXPECT_EQ(farthest([](auto& s, uint32_t i) { return int(s.size[i] >> 30); }), 0);
        EXPECT_LE(farthest([](auto& s, uint32_t i) { return int(s.colour[i] & 1023); }), half(1023, bits.colour - 1));
        EXPECT_LE(farthest([](auto& s, uint32_t i) { return int(s.colour[i] >> 21); }), half(2047, bits.colour));
        int phi = 0;  // periodic
        for (uint32_t i = 0; i < whole.count(); ++i) {
            const int off = std::abs(int(whole.place[i] >> 22) - int(coarse.place[i] >> 22));
            phi = std::max(phi, std::min(off, 1024 - off));
        }
        EXPECT_LE(phi, bits.phi == 10 ? 0 : 1 << (9 - bits.phi));
    }
}

TEST(CompactSplats, rangesOfAFewUlpsAreAFixedPointToo) {
    std::mt19937 random(5);
    for (int seed = 0; seed < 6; ++seed) {
        AvatarData a = tube();
        for (uint32_t i = 0; i < a.splats.count(); ++i) {
            const auto ulps = [&](float x) {
                for (uint32_t k = random() % (seed < 3 ? 4u : 300u); k > 0; --k) x = std::nextafter(x, 10.0f);
                return x;
            };
            a.splats.scaleM[i] = {ulps(0.01f), ulps(0.01f)};
            for (int k = 0; k < 3; ++k) a.splats.sh[i * 12 + k] = ulps(seed % 3 == 0 ? -0.5f : 0.5f);
        }
        for (const SplatBits& bits : kBits) {
            const auto bytes = writeAvatar(a, {.compact = true, .bits = bits});
            ASSERT_TRUE(bytes);
            const AvatarData back = *readAvatar(*bytes);
            EXPECT_TRUE(*writeAvatar(back, {.compact = true, .bits = bits}) == *bytes) << seed;
        }
    }
}

TEST(CompactSplats, manySplatsOnATriangleAndNoneOnMost) {
    AvatarData a = makeTube({.splatsPerTriangle = 1, .rings = 2, .shDegree = 0});
    const SplatData one = a.splats;
    std::vector<uint32_t> triangle;
    a.splats = {};
    for (uint32_t i = 0; i < 3000; ++i) {
        const uint32_t j = i % one.count();
        a.splats.uv.push_back(one.uv[j]), a.splats.phi.push_back(one.phi[j] + 0.001f * float(i)), a.splats.scaleM.push_back(one.scaleM[j]),
            a.splats.opacity.push_back(one.opacity[j]), a.splats.flags.push_back(one.flags[j]);
        for (int k = 0; k < 3; ++k) a.splats.sh.push_back(one.sh[j * 3 + k] + 0.001f * float(i % 77));
        triangle.push_back(i < 2000 ? 3 : 40 + i % 3);
    }
    ASSERT_TRUE(sortSplats(a, triangle));
    const auto bytes = writeAvatar(a, {.compact = true});
    ASSERT_TRUE(bytes);
    EXPECT_EQ(inspectAvatar(*bytes)->splatEncoding, 3u);
    EXPECT_TRUE(sameWords(wordsOf(*bytes), wordsOf(*writeAvatar(a))));
}

AvatarData corrected() {
    return test::withCorrectives(tube(0), 4, {.modes = 7, .nodes = 300});
}

TEST(CompactCorrectives, loadToTheSameAsTheStreams) {
    for (const uint32_t nodes :
         {1u, 2u, 40u, 300u, 2000u}) {  // up to 255 nodes all stay in the list of recent ones; a single node takes 0 bits
        const AvatarData a = test::withCorrectives(tube(0), nodes, {.modes = nodes > 1000 ? 2u : 7u, .nodes = nodes});
        const auto plain = writeAvatar(a), compact = writeAvatar(a, {.compact = true});
        ASSERT_TRUE(plain && compact);
        const AvatarInfo before = *inspectAvatar(*plain), after = *inspectAvatar(*compact);
        EXPECT_LT(after.correctiveBytes, before.correctiveBytes) << nodes;
        const PoseCorrectiveData one = readAvatar(*plain)->correctives, two = readAvatar(*compact)->correctives;
        EXPECT_TRUE(one.nodes == two.nodes && one.nodeIndices == two.nodeIndices && one.nodeWeights == two.nodeWeights &&
                    one.modes == two.modes && one.mean == two.mean)
            << nodes;
        EXPECT_TRUE(*writeAvatar(*readAvatar(*compact), {.compact = true}) == *compact);
    }
}

TEST(CompactCorrectives, damagedStreamsAreRefusedAndNothingCrashes) {
    using test::GlbParts;
    ReadLimits trusting;
    trusting.verifyHash = false;
    const std::vector<uint8_t> good = *writeAvatar(corrected(), {.draco = false, .compact = true});
    const auto ours = [](GlbParts& p) -> nlohmann::json& { return p.json["extensions"]["DPL_gaussian_avatar"]["poseCorrectives"]; };
    {
        GlbParts parts = test::split(good);
        ASSERT_EQ(ours(parts)["encoding"], 2);
        ASSERT_TRUE(readAvatar(parts.bytes(), trusting));
    }
    const std::pair<const char*, std::function<void(GlbParts&)>> damages[] = {
        {"read as encoding 1", [&](GlbParts& p) { ours(p)["encoding"] = 1; }},
        {"no coded", [&](GlbParts& p) { ours(p)["streams"].erase("coded"); }},
        {"nodes beside it", [&](GlbParts& p) { ours(p)["streams"]["nodes"] = ours(p)["streams"]["mean"]; }},
        {"one node more", [&](GlbParts& p) { ours(p)["nodeCount"] = 301; }},
        {"one node less", [&](GlbParts& p) { ours(p)["nodeCount"] = 299; }},
        {"65,535 nodes", [&](GlbParts& p) { ours(p)["nodeCount"] = 65535; }},
    };
    for (const auto& [what, apply] : damages) {
        GlbParts parts = test::split(good);
        apply(parts);
        EXPECT_FALSE(readAvatar(parts.bytes(), trusting)) << what;
    }
    std::mt19937 random(9);
    uint32_t refused = 0;
    for (int round = 0; round < 300; ++round) {
        GlbParts parts = test::split(good);
        const auto coded = parts.correctiveStream("coded");
        coded[round < 150 ? size_t(round) : random() % coded.size()] ^= uint8_t(1 + random() % 255);
        auto read = readAvatar(parts.bytes(), trusting);
        refused += !read;
        if (!read) continue;
        const auto once = writeAvatar(*read, {.compact = true});
        ASSERT_TRUE(once);
        EXPECT_TRUE(*writeAvatar(*readAvatar(*once), {.compact = true}) == *once);
    }
    EXPECT_GT(refused, 100u);
}

TEST(CompactSplats, damagedFilesAreRefusedAndNothingCrashes) {
    using Json = nlohmann::json;
    using test::GlbParts;
    ReadLimits trusting;
    trusting.verifyHash = false;
    AvatarData a = tube(1);
    for (size_t k = 0; k < a.splats.sh.size(); ++k)
        if (k % 12 >= 3) a.splats.sh[k] = a.splats.sh[k % 1200];
    const std::vector<uint8_t> good = *writeAvatar(a, {.draco = false, .shPalette = true, .compact = true, .bits = {9, 8, 9, 7, 9}});
    const auto splats = [](GlbParts& p) -> Json& { return p.json["extensions"]["DPL_gaussian_avatar"]["splats"]; };
    {
        GlbParts parts = test::split(good);
        ASSERT_TRUE(readAvatar(parts.bytes(), trusting));
    }
    const std::pair<const char*, std::function<void(GlbParts&)>> damages[] = {
        {"no bits", [&](GlbParts& p) { splats(p).erase("bits"); }},
        {"no bits of phi", [&](GlbParts& p) { splats(p)["bits"].erase("phi"); }},
        {"0 bits", [&](GlbParts& p) { splats(p)["bits"]["uv"] = 0; }},
        {"12 bits", [&](GlbParts& p) { splats(p)["bits"]["scale"] = 12; }},
        {"259 bits", [&](GlbParts& p) { splats(p)["bits"]["opacity"] = 259; }},
        {"1 bit of colour", [&](GlbParts& p) { splats(p)["bits"]["colour"] = 1; }},
        {"bits as a list",
         [&](GlbParts& p) {
             splats(p)["bits"] = Json::array({11, 10, 11, 8, 11});
         }},
        {"other bits", [&](GlbParts& p) { splats(p)["bits"]["uv"] = 8; }},
        {"one splat more", [&](GlbParts& p) { splats(p)["count"] = splats(p)["count"].get<int>() + 1; }},
        {"one splat less", [&](GlbParts& p) { splats(p)["count"] = splats(p)["count"].get<int>() - 1; }},
        {"sixteen million splats", [&](GlbParts& p) { splats(p)["count"] = 16 << 20; }},
        {"no splats", [&](GlbParts& p) { splats(p)["count"] = 0; }},
        {"read as encoding 2", [&](GlbParts& p) { splats(p)["encoding"] = 2; }},
        {"read as encoding 1", [&](GlbParts& p) { splats(p)["encoding"] = 1; }},
        {"ranges missing", [&](GlbParts& p) { splats(p)["streams"].erase("ranges"); }},
        {"coded missing", [&](GlbParts& p) { splats(p)["streams"].erase("coded"); }},
        {"words beside the coded", [&](GlbParts& p) { splats(p)["streams"]["place"] = splats(p)["streams"]["coded"]; }},
        {"palette of another size", [&](GlbParts& p) { splats(p)["shPaletteSize"] = splats(p)["shPaletteSize"].get<int>() - 1; }},
        {"no palette", [&](GlbParts& p) { splats(p).erase("shPaletteSize"); }},
        {"a range that falls", [&](GlbParts& p) { std::fill_n(p.stream("ranges").begin() + 12, 4, uint8_t(0x7f)); }},
        {"a palette range below 0", [&](GlbParts& p) { p.stream("ranges")[3] |= 0x80; }},
    };
    for (const auto& [what, apply] : damages) {
        GlbParts parts = test::split(good);
        apply(parts);
        auto read = readAvatar(parts.bytes(), trusting);
        EXPECT_FALSE(read) << what;
        if (!read) {
            EXPECT_FALSE(read.error().message.empty()) << what;
        }
    }
    // A changed byte of the coded stream gives an error, or an avatar that can be written and read again.
    std::mt19937 random(7);
    uint32_t refused = 0, changed = 0;
    for (int round = 0; round < 400; ++round) {
        GlbParts parts = test::split(good);
        const auto coded = parts.stream("coded");
        coded[round < 200 ? size_t(round) : random() % coded.size()] ^= uint8_t(1 + random() % 255);
        auto read = readAvatar(parts.bytes(), trusting);
        refused += !read, ++changed;
        if (!read) continue;
        const auto once = writeAvatar(*read, {.shPalette = true, .compact = true});
        ASSERT_TRUE(once);
        EXPECT_TRUE(*writeAvatar(*readAvatar(*once), {.shPalette = true, .compact = true}) == *once);
    }
    EXPECT_GT(refused, changed / 2);
    // A stream cut short.
    for (size_t cut : {size_t(1), size_t(100), size_t(10000)}) {
        GlbParts parts = test::split(good);
        auto& view = parts.json["bufferViews"][splats(parts)["streams"]["coded"].get<size_t>()];
        view["byteLength"] = view["byteLength"].get<size_t>() - cut;
        EXPECT_FALSE(readAvatar(parts.bytes(), trusting)) << cut;
    }
}

}  // namespace
}  // namespace dpl
