// SPDX-License-Identifier: Apache-2.0
// SPZ: single bytes by the definition of the format, files by the reference library, and damaged files.
#include "sdk/format/spz.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "tests/unit/format/splat_files.h"

namespace dpl {
namespace {

using namespace test;

// Half a step of: positions with 12 fractional bits; rotations of 10 bits (in version 2 of 8 bits, and w = √(1 − …) magnifies their error
// where it is small); log scales in 1/16; opacities in 1/255; colours in 1/255/0.15; SH in 1/128.
constexpr Tolerance kSpz = {0.00025f, 4e-6f, 0.033f, 0.0021f, 0.014f, 0.0041f}, kSpz2 = {0.00025f, 6e-4f, 0.033f, 0.0021f, 0.014f, 0.0041f};

TEST(Spz, readsWhatTheReferenceLibraryWrites) {
    const StaticSplatData want = pinnedSplats();
    for (uint32_t version = 2; version <= 4; ++version) {
        auto file = readSplats(pinned(formatText("splats_v{}.spz", version).c_str()));
        ASSERT_TRUE(file) << version << ": " << file.error().message;
        EXPECT_EQ(file->format, SplatFormat::Spz);
        EXPECT_EQ(file->version, version);
        EXPECT_EQ(file->splats.compensated, version == 3) << "the pinned file of version 3 says 'antialiased'";
        EXPECT_EQ(file->splats.kappaPx2, 0.3f);
        expectSplats(file->splats, want, version == 2 ? kSpz2 : kSpz);
    }
}

Bytes gzip(const Bytes& in) {
    Bytes out(in.size() + 1024);
    z_stream stream{};
    EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
    stream.next_in = const_cast<Bytef*>(in.data()), stream.avail_in = uInt(in.size());
    stream.next_out = out.data(), stream.avail_out = uInt(out.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

/** A hand-made file of one splat. */
struct SpzByHand {
    uint32_t magic = 0x5053474e, version = 3, count = 1;
    uint8_t degree = 0, fractionalBits = 12, flags = 0;
    Bytes body;

    Bytes plain() const {
        Bytes out;
        append(out, magic), append(out, version), append(out, count);
        for (const uint8_t b : {degree, fractionalBits, flags, uint8_t(0)}) out.push_back(b);
        out.insert(out.end(), body.begin(), body.end());
        return out;
    }
    Bytes packed() const { return gzip(plain()); }
};

SpzByHand oneSpzSplat() {
    SpzByHand f;
    f.body = {0x00, 0x10, 0x00, 0xff, 0xff, 0xff, 0x00, 0x00, 0x80,  // 4096 = 1 m, −1 step, −2^23 steps
              51,                                                    // opacity 0.2
              0,    128,  255,                                       // colour
              160,  0,    255,                                       // log scale 0, −10, 5.9375
              0xff, 0x01, 0x00, 0xc0};                               // w is left out, x = y = 0, z = 511/511/√2: a quarter turn about z
    return f;
}

TEST(Spz, decodesByteByByteAsDefined) {
    auto s = readSpz(oneSpzSplat().packed());
    ASSERT_TRUE(s) << s.error().message;
    EXPECT_EQ(s->position[0], Vec3f(1, -1.0f / 4096, -2048));
    EXPECT_FLOAT_EQ(s->opacity[0], 0.2f);
    EXPECT_FLOAT_EQ(s->sh[0], -0.5f / 0.15f);
    EXPECT_FLOAT_EQ(s->sh[2], 0.5f / 0.15f);
    EXPECT_FLOAT_EQ(s->scaleM[0].x, 1);
    EXPECT_FLOAT_EQ(s->scaleM[0].y, std::exp(-10.0f));
    EXPECT_FLOAT_EQ(s->scaleM[0].z, std::exp(5.9375f));
    EXPECT_NEAR(s->rotation[0].z, std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(s->rotation[0].w, std::sqrt(0.5), 1e-6);
    SpzByHand coarse = oneSpzSplat();
    coarse.fractionalBits = 8;
    EXPECT_EQ(readSpz(coarse.packed())->position[0].x, 16);
    SpzByHand negative = oneSpzSplat();
    negative.body[17] |= 0x02;  // the sign of z
    EXPECT_NEAR(readSpz(negative.packed())->rotation[0].z, -std::sqrt(0.5), 1e-6);
    SpzByHand old = oneSpzSplat();
    old.version = 2, old.body.resize(16), old.body.insert(old.body.end(), {0, 255, 0});  // −1, +1, −1: longer than a unit quaternion may be
    EXPECT_NEAR(readSpz(old.packed())->rotation[0].y, std::sqrt(1 / 3.0), 1e-6);
}

TEST(Spz, bandsAboveDegree3AreDroppedAndExtensionsSkipped) {
    SpzByHand rich = oneSpzSplat();
    rich.degree = 4, rich.flags = 2;
    for (int k = 0; k < 72; ++k) rich.body.push_back(uint8_t(128 + k));
    rich.body.insert(rich.body.end(), 100, 7);
    auto file = readSplats(rich.packed());
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->remarks.shDegree, 4u);
    EXPECT_EQ(file->splats.shDegree, 3u);
    EXPECT_EQ(file->splats.sh.size(), 48u);
    EXPECT_EQ(file->splats.sh[47], 44 / 128.0f);
    Bytes modern = pinned("splats_v4.spz");
    const uint32_t tableAt = 48;
    std::memcpy(&modern[16], &tableAt, 4), modern[14] |= 2;
    modern.insert(modern.begin() + 32, 16, 0xee);
    auto moved = readSplats(modern);
    ASSERT_TRUE(moved) << moved.error().message;
    EXPECT_EQ(moved->splats.count(), 7u);
}

/** In a gzip stream the extensions lie behind the attributes. */
TEST(Spz, theCoordinateExtensionOfVersion3IsHeard) {
    SpzByHand f = oneSpzSplat();
    f.flags = 2;
    for (const uint32_t word : {0xadbe0003u, 4u, 6u}) append(f.body, word);  // right, down, front
    auto file = readSplats(f.packed());
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->splats.position[0], Vec3f(1, 1.0f / 4096, 2048));
    EXPECT_EQ(file->remarks.axes.stated, "x right, y down, z front");
}

TEST(Spz, rejectList) {
    const auto changed = [](auto change) {
        SpzByHand f = oneSpzSplat();
        change(f);
        return readSplats(f.packed());
    };
    expectRefused(changed([](SpzByHand& f) { f.magic = 1; }), "another gzip file", Code::Unsupported, "NGSP");
    expectRefused(changed([](SpzByHand& f) { f.version = 1; }), "version 1", Code::Version, "2 to 4");
    expectRefused(changed([](SpzByHand& f) { f.version = 5; }), "version 5", Code::Version, "update Doppel");
    expectRefused(changed([](SpzByHand& f) { f.version = 4; }), "version 4 in gzip", Code::CorruptData, "gzip");
    expectRefused(changed([](SpzByHand& f) { f.degree = 5; }), "SH degree 5", Code::CorruptData, "SH degree 5");
    expectRefused(changed([](SpzByHand& f) { f.fractionalBits = 32; }), "32 fractional bits", Code::CorruptData, "fractional");
    expectRefused(changed([](SpzByHand& f) { f.count = 2; }), "a splat too few", Code::CorruptData, "truncated");
    expectRefused(changed([](SpzByHand& f) { f.count = 0xffffffff; }), "4 billion splats", Code::CorruptData, "limit");
    expectRefused(changed([](SpzByHand& f) { f.count = 10'000'000; }), "10 million splats in 60 bytes", Code::CorruptData, "no real file");
    expectRefused(changed([](SpzByHand& f) { f.body.push_back(0); }), "a byte too many", Code::CorruptData, "more data");
    expectRefused(changed([](SpzByHand& f) { f.flags = 2, f.body.insert(f.body.end(), 3 << 20, 0); }), "3 MiB of extensions",
                  Code::CorruptData, "more data");
    expectRefused(readSplats(oneSpzSplat().plain()), "version 3 without gzip", Code::CorruptData, "outside a gzip stream");
    const auto changed4 = [](size_t at, auto value) {
        Bytes bytes = pinned("splats_v4.spz");
        std::memcpy(&bytes[at], &value, sizeof value);
        return readSplats(bytes);
    };
    expectRefused(changed4(15, uint8_t(5)), "a stream too few", Code::CorruptData, "5 streams");
    expectRefused(changed4(16, uint32_t(8)), "the table in the header", Code::CorruptData, "inside the header");
    expectRefused(changed4(16, uint32_t(0xfffffff0)), "the table behind the end", Code::CorruptData, "left");
    expectRefused(changed4(32, uint64_t(1) << 40), "a stream of 2^40 bytes", Code::CorruptData, "left");
    expectRefused(changed4(40, uint64_t(1) << 40), "a stream that unpacks to 2^40 bytes", Code::CorruptData, "needed");
}

TEST(Spz, truncatedAndFlippedFilesDoNoHarm) {
    for (const char* name : {"splats_v2.spz", "splats_v3.spz", "splats_v4.spz"}) expectSturdy(pinned(name));
}

}  // namespace
}  // namespace dpl
