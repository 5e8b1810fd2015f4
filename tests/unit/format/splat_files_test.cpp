// Files of general splats: what each format's definition says about its bytes, files that other people's programs wrote, and hostile ones.
#include <gtest/gtest.h>

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/compressed_ply.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"
#include "sdk/format/splat_file.h"
#include "sdk/format/spz.h"
#include "sdk/math/sh_rotation.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes fileBytes(const std::filesystem::path& path) {
    auto bytes = readFile(path);
    EXPECT_TRUE(bytes) << path;
    return bytes ? *bytes : Bytes{};
}
Bytes pinned(const char* name) { return fileBytes(sourceFolder() / "tests/unit/format/pinned" / name); }

/** What the pinned files hold. splats_v*.spz come from the reference library (@adobe/spz, 8 bits of SH), splats.compressed.ply and
 *  splats_khr.glb from PlayCanvas' splat-transform 2.7.1, which sorts them in its own way and turns the .glb half around z. */
StaticSplatData pinnedSplats() {
    StaticSplatData s;
    s.shDegree = 3;
    const Quatf turns[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}, {0.5f, 0.5f, -0.5f, 0.5f}, {0.8f, 0, 0, -0.6f}, {-0.1f, 0.7f, 0.1f, -0.7f}};
    for (int i = 0; i < 7; ++i) {
        s.position.emplace_back(0.25f * i - 1, 0.5f - 0.125f * i, 0.0625f * i);
        s.rotation.push_back(glm::normalize(turns[i]));
        s.scaleM.emplace_back(0.01f * (i + 1), 0.02f, 0.04f / (i + 1));
        s.opacity.push_back((i + 1) / 8.0f);
        for (const float dc : {0.2f * i - 0.6f, 0.5f, -0.1f * i}) s.sh.push_back(dc);
        for (int k = 0; k < 15; ++k)
            for (int c = 0; c < 3; ++c) s.sh.push_back(0.9f * std::sin(0.7f * k + 1.3f * c + 0.5f * i));
    }
    return s;
}

struct Tolerance {
    float place, turn, scaleShare, opacity, dc, rest;
};

/** `read` holds the splats of `want` in any order, told apart by place. */
void expectSplats(const StaticSplatData& read, const StaticSplatData& want, const Tolerance& t) {
    ASSERT_EQ(read.count(), want.count());
    ASSERT_EQ(read.shDegree, want.shDegree);
    const uint32_t floats = shCoefficientCount(want.shDegree) * 3;
    ASSERT_EQ(read.sh.size(), want.sh.size());
    for (size_t i = 0; i < want.count(); ++i) {
        size_t j = 0;
        for (size_t k = 1; k < read.count(); ++k)
            if (glm::length(read.position[k] - want.position[i]) < glm::length(read.position[j] - want.position[i])) j = k;
        EXPECT_LE(glm::length(read.position[j] - want.position[i]), t.place) << i;
        EXPECT_GE(std::abs(glm::dot(read.rotation[j], want.rotation[i])), 1 - t.turn) << i;
        EXPECT_NEAR(glm::length(read.rotation[j]), 1, 1e-5) << i;
        for (int a = 0; a < 3; ++a) EXPECT_NEAR(read.scaleM[j][a] / want.scaleM[i][a], 1, t.scaleShare) << i << " axis " << a;
        EXPECT_NEAR(read.opacity[j], want.opacity[i], t.opacity) << i;
        for (size_t k = 0; k < floats; ++k) EXPECT_NEAR(read.sh[j * floats + k], want.sh[i * floats + k], k < 3 ? t.dc : t.rest) << i << " SH " << k;
    }
}

void expectRefused(const Result<SplatFile>& result, const char* what, Code code, const char* says) {
    ASSERT_FALSE(result) << what << " was accepted";
    EXPECT_EQ(int(result.error().code), int(code)) << what << ": " << result.error().message;
    EXPECT_NE(result.error().message.find(says), std::string::npos) << what << ": " << result.error().message;
}

/** Every truncation is refused; a flipped bit is refused or read, never worse. */
void expectSturdy(const Bytes& good) {
    ASSERT_TRUE(readSplats(good));
    for (size_t size = 0; size < good.size(); ++size) {
        auto cut = readSplats(std::span(good).first(size));
        ASSERT_FALSE(cut) << "cut to " << size << " of " << good.size();
        EXPECT_FALSE(cut.error().message.empty());
    }
    for (size_t at = 0; at < good.size(); ++at)
        for (int bit = 0; bit < 8; bit += 3) {
            Bytes bad = good;
            bad[at] ^= uint8_t(1 << bit);
            auto read = readSplats(bad);
            if (!read) continue;
            for (const Vec3f& p : read->splats.position) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z)) << at;
            for (const float v : read->splats.sh) ASSERT_TRUE(std::isfinite(v)) << at;
        }
}

// ---------------------------------------------------------------- SPZ

// Half a step of: 12 fractional bits an axis, 10-bit rotations (in version 2 8 bits, and w = √(1 − …) makes more of their error where it is small), 1/16 in log scale, 1/255, 1/255/0.15, 1/128.
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

template <class T>
void append(Bytes& out, T value) {
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    out.insert(out.end(), raw, raw + sizeof(T));
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

/** One splat by hand. */
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
    f.body = {0x00, 0x10, 0x00, 0xff, 0xff, 0xff, 0x00, 0x00, 0x80,   // 4096 = 1 m, −1 step, −2^23 steps
              51,                                                      // opacity 0.2
              0, 128, 255,                                             // colour
              160, 0, 255,                                             // log scale 0, −10, 5.9375
              0xff, 0x01, 0x00, 0xc0};                                 // w left out, x = y = 0, z = 511/511/√2: a quarter turn about z
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
    negative.body[17] |= 0x02;   // the sign of z
    EXPECT_NEAR(readSpz(negative.packed())->rotation[0].z, -std::sqrt(0.5), 1e-6);
    SpzByHand old = oneSpzSplat();
    old.version = 2, old.body.resize(16), old.body.insert(old.body.end(), {0, 255, 0});   // −1, +1, −1: longer than a unit quaternion may be
    EXPECT_NEAR(readSpz(old.packed())->rotation[0].y, std::sqrt(1 / 3.0), 1e-6);
}

TEST(Spz, bandsAboveDegree3AreDroppedAndExtensionsSkipped) {
    SpzByHand rich = oneSpzSplat();
    rich.degree = 4, rich.flags = 2;
    for (int k = 0; k < 72; ++k) rich.body.push_back(uint8_t(128 + k));
    rich.body.insert(rich.body.end(), 100, 7);
    auto file = readSplats(rich.packed());
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->shDegree, 4u);
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
    expectRefused(changed([](SpzByHand& f) { f.flags = 2, f.body.insert(f.body.end(), 3 << 20, 0); }), "3 MiB of extensions", Code::CorruptData, "more data");
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

// ---------------------------------------------------------------- compressed PLY

/** 300 splats in two chunks, SH degree 1, by hand. */
struct CompressedPlyByHand {
    uint32_t count = 300, chunks = 2, shRows = 300;
    bool chunkColours = true;
    std::vector<std::array<uint32_t, 4>> words = std::vector<std::array<uint32_t, 4>>(300, {0, 0, 0, 0});
    std::vector<std::array<uint8_t, 9>> sh = std::vector<std::array<uint8_t, 9>>(300);
    float ranges[2][18] = {{0, 0, 0, 1, 2, 4, -5, -5, -5, -3, -3, -3, 0, 0, 0, 1, 1, 1}, {10, 20, 30, 10, 20, 30, -4, -4, -4, -4, -4, -4, -1, -1, -1, 2, 2, 2}};

    Bytes bytes() const {
        std::string header = "ply\nformat binary_little_endian 1.0\ncomment by hand\nelement chunk " + std::to_string(chunks) + "\n";
        for (const char* name : {"min_x", "min_y", "min_z", "max_x", "max_y", "max_z", "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z"})
            header += std::string("property float ") + name + "\n";
        if (chunkColours)
            for (const char* name : {"min_r", "min_g", "min_b", "max_r", "max_g", "max_b"}) header += std::string("property float ") + name + "\n";
        header += "element vertex " + std::to_string(count) + "\n";
        for (const char* name : {"packed_position", "packed_rotation", "packed_scale", "packed_color"}) header += std::string("property uint ") + name + "\n";
        header += "element sh " + std::to_string(shRows) + "\n";
        for (int k = 0; k < 9; ++k) header += "property uchar f_rest_" + std::to_string(k) + "\n";
        header += "end_header\n";
        Bytes out(header.begin(), header.end());
        for (const auto& range : ranges)
            for (int k = 0; k < (chunkColours ? 18 : 12); ++k) append(out, range[k]);
        for (const auto& row : words) append(out, row);
        for (const auto& row : sh) append(out, row);
        return out;
    }
};

TEST(CompressedPly, decodesWordByWordAsDefined) {
    CompressedPlyByHand f;
    f.words[0] = {0xffffffff, 512u << 20 | 512u << 10 | 1023u, 0xffffffff, 0xff8000ff};   // rotation: w left out, z at its largest
    f.words[1] = {2047u << 21, 1u << 30 | 1023u << 20 | 512u << 10 | 512u, 1023u << 11, 0x00ff0033};   // x left out, w at its largest
    f.words[299] = {0, 3u << 30 | 512u << 20 | 512u << 10 | 0u, 0, 0xff00ff00};           // z left out, y at its smallest
    f.sh[0] = {0, 255, 128, 127, 1, 2, 3, 4, 5};
    auto s = readCompressedPly(f.bytes());
    ASSERT_TRUE(s) << s.error().message;
    EXPECT_EQ(s->count(), 300u);
    EXPECT_EQ(s->position[0], Vec3f(1, 2, 4));
    EXPECT_EQ(s->position[1], Vec3f(1, 0, 0));
    EXPECT_EQ(s->position[299], Vec3f(10, 20, 30)) << "the second chunk";
    const float half = float(std::sqrt(0.5));
    for (int k = 0; k < 3; ++k) EXPECT_FLOAT_EQ(s->scaleM[0][k], std::exp(-3.0f));
    EXPECT_FLOAT_EQ(s->scaleM[1].y, std::exp(-3.0f));
    EXPECT_FLOAT_EQ(s->scaleM[1].x, std::exp(-5.0f));
    EXPECT_GT(glm::dot(s->rotation[0], Quatf(half, 0, 0, half)), 0.99999f);
    EXPECT_GT(glm::dot(s->rotation[1], Quatf(half, half, 0, 0)), 0.99999f);
    EXPECT_GT(glm::dot(s->rotation[299], Quatf(0, 0, -half, half)), 0.99999f);
    EXPECT_FLOAT_EQ(s->opacity[0], 1);
    EXPECT_FLOAT_EQ(s->opacity[1], 0.2f);
    const size_t floats = 12;
    EXPECT_FLOAT_EQ(s->sh[0], 0.5f / float(kShC0));
    EXPECT_NEAR(s->sh[1], (128 / 255.0 - 0.5) / kShC0, 1e-6);
    EXPECT_FLOAT_EQ(s->sh[299 * floats], 1.5f / float(kShC0)) << "colours of the second chunk reach 2";
    // Nine bytes: three of red, of green, of blue; 256 bins over [−4, 4], the end bins are the ends.
    EXPECT_EQ(s->sh[3], -4);
    EXPECT_EQ(s->sh[6], 4);
    EXPECT_EQ(s->sh[9], 0.015625f);
    EXPECT_EQ(s->sh[4], -0.015625f);
    f.chunkColours = false;
    auto old = readCompressedPly(f.bytes());
    ASSERT_TRUE(old) << old.error().message;
    EXPECT_FLOAT_EQ(old->sh[299 * floats], 0.5f / float(kShC0)) << "older files: colours within [0, 1]";
}

TEST(CompressedPly, readsWhatSplatTransformWrites) {
    auto file = readSplats(pinned("splats.compressed.ply"));
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->format, SplatFormat::CompressedPly);
    // Half a step over the range of one chunk: 1.5 m in 11 or 10 bits; 10-bit rotations; e^1.95 in 11 bits; 8 bits; 8 bits over [−4, 4], floored.
    expectSplats(file->splats, pinnedSplats(), {0.0008f, 4e-6f, 0.002f, 0.002f, 0.0085f, 0.0157f});
}

TEST(CompressedPly, rejectList) {
    const auto changed = [](auto change) {
        CompressedPlyByHand f;
        change(f);
        return readSplats(f.bytes());
    };
    expectRefused(changed([](auto& f) { f.chunks = 1; }), "a chunk too few", Code::CorruptData, "1 chunks for 300 splats");
    expectRefused(changed([](auto& f) { f.count = 301; }), "a splat too many", Code::CorruptData, "");
    expectRefused(changed([](auto& f) { f.count = 4'000'000'000; }), "4 billion splats", Code::CorruptData, "truncated");
    expectRefused(changed([](auto& f) { f.chunks = 4'000'000'000; }), "4 billion chunks", Code::CorruptData, "truncated");
    expectRefused(changed([](auto& f) { f.shRows = 299; }), "a row of SH too few", Code::CorruptData, "299 rows of SH");
    expectRefused(changed([](auto& f) { f.ranges[1][4] = NAN; }), "a range that is no number", Code::CorruptData, "chunk 1 is not finite");
    expectRefused(changed([](auto& f) { f.ranges[0][9] = 200, f.words[0][2] = 0xffffffff; }), "a scale of e^200", Code::CorruptData, "splat 0 is not finite");
    const auto renamed = [](const std::string& from, const std::string& to) {
        const Bytes good = CompressedPlyByHand().bytes();
        std::string text(good.begin(), good.end());
        text.replace(text.find(from), from.size(), to);
        return readSplats(std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
    };
    expectRefused(renamed("uint packed_scale", "uint backed_scale"), "no scales", Code::CorruptData, "packed_scale");
    expectRefused(renamed("uint packed_scale", "float packed_scale"), "scales as floats", Code::CorruptData, "packed_scale");
    expectRefused(renamed("float max_z", "float most_z"), "half a range", Code::CorruptData, "max_z");
    expectRefused(renamed("float max_b", "float most_b"), "half a range of colours", Code::CorruptData, "max_b");
    expectRefused(renamed("uchar f_rest_8", "uchar g_rest_8"), "eight SH bytes", Code::CorruptData, "8 f_rest");
    expectRefused(renamed("element vertex", "element vertices"), "no vertices", Code::CorruptData, "'vertex'");
    expectRefused(renamed("float min_x", "list uchar int min_x"), "a list", Code::Unsupported, "list");
    expectRefused(renamed("binary_little_endian", "ascii"), "an ASCII file", Code::Unsupported, "binary");
}

TEST(CompressedPly, truncatedAndFlippedFilesDoNoHarm) { expectSturdy(pinned("splats.compressed.ply")); }

// ---------------------------------------------------------------- glTF

constexpr Tolerance kExact = {1e-6f, 1e-6f, 1e-6f, 1e-6f, 1e-6f, 1e-6f};

StaticSplatData ofDegree(uint32_t degree) {
    StaticSplatData s = pinnedSplats(), out = s;
    out.shDegree = degree, out.sh.clear();
    for (size_t i = 0; i < s.count(); ++i) out.sh.insert(out.sh.end(), s.sh.begin() + ptrdiff_t(i * 48), s.sh.begin() + ptrdiff_t(i * 48 + shCoefficientCount(degree) * 3));
    return out;
}

TEST(GltfSplats, readsBackWhatWeWriteAtEveryShDegree) {
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        const StaticSplatData want = ofDegree(degree);
        auto file = readSplats(*writeGltfSplats(want));
        ASSERT_TRUE(file) << file.error().message;
        EXPECT_EQ(file->format, SplatFormat::Gltf);
        EXPECT_FALSE(file->splats.compensated);
        expectSplats(file->splats, want, kExact);
    }
}

TEST(GltfSplats, readsWhatSplatTransformWrites) {
    auto file = readSplats(pinned("splats_khr.glb"));
    ASSERT_TRUE(file) << file.error().message;
    StaticSplatData want = pinnedSplats();
    const Mat3d halfTurn(-1, 0, 0, 0, -1, 0, 0, 0, 1);   // it takes a PLY to be y-down and turns it upright about z
    const ShRotator rotator;
    for (size_t i = 0; i < want.count(); ++i) {
        want.position[i] = Mat3f(halfTurn) * want.position[i];
        want.rotation[i] = Quatf(0, 0, 0, 1) * want.rotation[i];
        rotator.rotate(halfTurn, 3, &want.sh[i * 48]);
    }
    expectSplats(file->splats, want, {1e-6f, 1e-6f, 1e-5f, 1e-6f, 1e-6f, 2e-6f});
}

/** Nodes place their splats: position, axes and the directions of SH turn along. */
TEST(GltfSplats, nodesPlaceTheirSplats) {
    const StaticSplatData one = ofDegree(3);
    auto parts = test::split(*writeGltfSplats(one));
    parts.json["nodes"] = {{{"children", {1}}, {"translation", {1, 2, 3}}, {"rotation", {0, 0.70710678, 0, 0.70710678}}},
                           {{"mesh", 0}, {"scale", {2, 2, 2}}, {"rotation", {0.6, 0, 0, 0.8}}, {"translation", {0.5, -1, 2}}}};
    auto placed = readGltfSplats(parts.bytes());
    ASSERT_TRUE(placed) << placed.error().message;
    const Quatf outer(0.70710678f, 0, 0.70710678f, 0), turn = outer * Quatf(0.8f, 0.6f, 0, 0);
    const Vec3f direction = glm::normalize(Vec3f(0.3f, -0.5f, 0.8f));
    for (size_t i = 0; i < one.count(); ++i) {
        EXPECT_LT(glm::length(placed->position[i] - (turn * (2.0f * one.position[i]) + outer * Vec3f(0.5f, -1, 2) + Vec3f(1, 2, 3))), 1e-5f);
        EXPECT_LT(glm::length(placed->scaleM[i] - 2.0f * one.scaleM[i]), 1e-6f);
        EXPECT_GT(std::abs(glm::dot(placed->rotation[i], turn * one.rotation[i])), 0.99999f);
        const Vec3f was = shColour(&one.sh[i * 48], 3, direction), is = shColour(&placed->sh[i * 48], 3, turn * direction);
        EXPECT_LT(glm::length(is - was), 1e-5f) << i;
    }
    parts.json["nodes"][1]["scale"] = {2, 2, 2.1};
    expectRefused(readSplats(parts.bytes()), "axes scaled differently", Code::Unsupported, "apply its transform");
    parts.json["nodes"][1]["scale"] = {-1, -1, -1};
    expectRefused(readSplats(parts.bytes()), "a mirror", Code::Unsupported, "mirrors");
}

/** Two primitives of different SH degree become one set; a mesh beside them is skipped. Integer attributes count as the extension says. */
TEST(GltfSplats, primitivesAreJoinedAndIntegersDecoded) {
    auto parts = test::split(*writeGltfSplats(ofDegree(1)));
    const size_t at = parts.bin.size();
    const auto addAttribute = [&](const Bytes& raw, int component, const char* type, bool normalized) {
        const size_t offset = parts.bin.size(), index = parts.json["accessors"].size();
        parts.bin.insert(parts.bin.end(), raw.begin(), raw.end());
        while (parts.bin.size() % 4) parts.bin.push_back(0);
        parts.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", raw.size()}});
        parts.json["accessors"].push_back({{"bufferView", parts.json["bufferViews"].size() - 1}, {"componentType", component}, {"type", type}, {"count", 1}, {"normalized", normalized}});
        return index;
    };
    Bytes place, colour;
    for (const float v : {9.0f, 8.0f, 7.0f}) append(place, v), append(colour, v / 10);
    nlohmann::json attributes;
    attributes["POSITION"] = addAttribute(place, 5126, "VEC3", false);
    attributes["KHR_gaussian_splatting:ROTATION"] = addAttribute({0, 127, 0, 0}, 5120, "VEC4", true);
    attributes["KHR_gaussian_splatting:SCALE"] = addAttribute({1, 2, 3}, 5121, "VEC3", false);
    attributes["KHR_gaussian_splatting:OPACITY"] = addAttribute({51}, 5121, "SCALAR", true);
    attributes["KHR_gaussian_splatting:SH_DEGREE_0_COEF_0"] = addAttribute(colour, 5126, "VEC3", false);
    ASSERT_GT(parts.bin.size(), at);
    parts.json["buffers"][0]["byteLength"] = parts.bin.size();
    nlohmann::json primitive = parts.json["meshes"][0]["primitives"][0], plain = primitive;
    primitive["attributes"] = attributes;
    plain.erase("extensions");
    parts.json["meshes"][0]["primitives"].push_back(primitive);
    parts.json["meshes"][0]["primitives"].push_back(plain);
    auto s = readGltfSplats(parts.bytes());
    ASSERT_TRUE(s) << s.error().message;
    ASSERT_EQ(s->count(), 8u);
    EXPECT_EQ(s->shDegree, 1u);
    EXPECT_EQ(s->position[7], Vec3f(9, 8, 7));
    EXPECT_EQ(s->rotation[7], Quatf(0, 0, 1, 0));
    EXPECT_EQ(s->scaleM[7], Vec3f(1, 2, 3));
    EXPECT_FLOAT_EQ(s->opacity[7], 0.2f);
    EXPECT_FLOAT_EQ(s->sh[7 * 12 + 1], 0.8f);
    for (size_t k = 3; k < 12; ++k) EXPECT_EQ(s->sh[7 * 12 + k], 0);
}

TEST(GltfSplats, rejectList) {
    const auto changed = [](auto change) {
        auto parts = test::split(*writeGltfSplats(ofDegree(1)));
        change(parts, parts.json["meshes"][0]["primitives"][0]);
        return readSplats(parts.bytes());
    };
    const auto with = [&](const char* key, const char* value) {
        return changed([&](auto&, auto& p) { p["extensions"]["KHR_gaussian_splatting"][key] = value; });
    };
    expectRefused(with("kernel", "cube"), "a kernel", Code::Unsupported, "'cube'");
    expectRefused(with("projection", "fisheye"), "a projection", Code::Unsupported, "'fisheye'");
    expectRefused(with("colorSpace", "lin_rec709_display"), "linear colour", Code::Unsupported, "srgb_rec709_display");
    expectRefused(with("sortingMethod", "none"), "unsorted", Code::Unsupported, "'none'");
    expectRefused(changed([](auto&, auto& p) { p["extensions"]["KHR_gaussian_splatting"]["extensions"]["KHR_gaussian_splatting_compression_spz_2"]["bufferView"] = 0; }),
                  "compressed", Code::Unsupported, "compression_spz_2");
    expectRefused(changed([](auto&, auto& p) { p["mode"] = 4; }), "triangles", Code::CorruptData, "mode 4");
    for (const char* name : {"POSITION", "KHR_gaussian_splatting:ROTATION", "KHR_gaussian_splatting:SCALE", "KHR_gaussian_splatting:OPACITY", "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0",
                             "KHR_gaussian_splatting:SH_DEGREE_1_COEF_2"})
        expectRefused(changed([&](auto&, auto& p) { p["attributes"].erase(name); }), name, Code::CorruptData, name);
    expectRefused(changed([](auto& parts, auto& p) { parts.json["accessors"][p["attributes"]["KHR_gaussian_splatting:OPACITY"].template get<size_t>()]["count"] = 6; }), "six opacities", Code::CorruptData, "6 entries");
    const auto damaged = [&](const char* attribute, size_t index, float value) {
        return changed([&](auto& parts, auto& p) { std::memcpy(parts.accessor(p["attributes"][attribute].template get<size_t>()).data() + index * 4, &value, 4); });
    };
    expectRefused(damaged("KHR_gaussian_splatting:SCALE", 4, -0.1f), "a negative scale", Code::CorruptData, "negative");
    expectRefused(damaged("KHR_gaussian_splatting:OPACITY", 3, 1.5f), "an opacity of 1.5", Code::CorruptData, "opacity");
    expectRefused(damaged("KHR_gaussian_splatting:OPACITY", 3, NAN), "an opacity that is no number", Code::CorruptData, "finite");
    expectRefused(damaged("KHR_gaussian_splatting:ROTATION", 3, 0.0f), "no rotation", Code::CorruptData, "rotation");
    expectRefused(changed([](auto& parts, auto&) { parts.json["nodes"][0].erase("mesh"); }), "shown by no node", Code::Unsupported, "no node");
    expectRefused(changed([](auto& parts, auto&) { for (int i = 0; i < 9; ++i) parts.json["nodes"].push_back({{"mesh", 0}}); }), "ten instances", Code::CorruptData, "more than once");
    expectRefused(changed([](auto& parts, auto&) { parts.json["nodes"][0]["scale"] = {1e38, 1e38, 1e38}, parts.json["nodes"][0]["translation"] = {1e38, 3e38, 0}; }), "beyond float", Code::CorruptData, "not finite");
}

TEST(GltfSplats, truncatedFilesAndFlippedBitsDoNoHarm) { expectSturdy(*writeGltfSplats(ofDegree(0))); }

// ---------------------------------------------------------------- all of them

TEST(SplatFile, isToldByItsContent) {
    EXPECT_EQ(splatFormatOf(*writePly(ofDegree(0))), SplatFormat::InriaPly);
    EXPECT_EQ(splatFormatOf(CompressedPlyByHand().bytes()), SplatFormat::CompressedPly);
    EXPECT_EQ(splatFormatOf(pinned("splats_v2.spz")), SplatFormat::Spz);
    EXPECT_EQ(splatFormatOf(pinned("splats_v4.spz")), SplatFormat::Spz);
    EXPECT_EQ(splatFormatOf(*writeGltfSplats(ofDegree(0))), SplatFormat::Gltf);
    EXPECT_EQ(splatFormatOf(*writeAvatar(test::tinyAvatar())), SplatFormat::None);
    EXPECT_EQ(splatFormatOf({}), SplatFormat::None);
    const Bytes text = {'h', 'e', 'l', 'l', 'o'};
    expectRefused(readSplats(text), "some text", Code::Unsupported, "PLY, compressed PLY, SPZ");
    ReadLimits small;
    small.maxFileBytes = 100;
    expectRefused(readSplats(pinned("splats_v4.spz"), small), "a file above the limit", Code::CorruptData, "limit");
}

TEST(SplatFile, plainPlyStillReads) {
    auto file = readSplats(*writePly(pinnedSplats()));
    ASSERT_TRUE(file) << file.error().message;
    expectSplats(file->splats, pinnedSplats(), {1e-6f, 1e-6f, 1e-5f, 1e-6f, 1e-6f, 1e-6f});
    auto compressed = readPly(CompressedPlyByHand().bytes());
    ASSERT_FALSE(compressed);
    EXPECT_NE(compressed.error().message.find("compressed PLY"), std::string::npos);
    expectSturdy(*writePly(ofDegree(0)));
}

/** splat-transform writes the logit of 1 as +∞. */
TEST(SplatFile, plyWithInfiniteLogitsAndLogScalesReads) {
    const Bytes good = *writePly(ofDegree(0), {.normals = false});
    const size_t body = good.size() - 7 * 14 * 4;   // x y z, dc, opacity, scale, rotation
    const auto with = [&](size_t splat, size_t column, float value) {
        Bytes bytes = good;
        std::memcpy(&bytes[body + (splat * 14 + column) * 4], &value, 4);
        return readSplats(bytes);
    };
    auto solid = with(2, 6, INFINITY), gone = with(2, 6, -INFINITY), flat = with(3, 8, -INFINITY);
    ASSERT_TRUE(solid && gone && flat);
    EXPECT_EQ(solid->splats.opacity[2], 1);
    EXPECT_EQ(gone->splats.opacity[2], 0);
    EXPECT_EQ(flat->splats.scaleM[3].y, 0);
    expectRefused(with(2, 6, NAN), "an opacity that is no number", Code::CorruptData, "splat 2");
    expectRefused(with(3, 8, INFINITY), "a scale without end", Code::CorruptData, "splat 3");
    expectRefused(with(3, 0, INFINITY), "a place without end", Code::CorruptData, "splat 3");
}

TEST(SplatFile, boxLeavesOutStrays) {
    StaticSplatData s;
    for (int i = 0; i < 1000; ++i) s.position.emplace_back(i % 10, i % 7, -(i % 5));
    s.position[3] = {1e6f, -1e6f, 1e6f}, s.position[500] = {-1e6f, 1e6f, -1e6f};
    const SplatBox box = boxOf(s);
    EXPECT_EQ(box.low, Vec3f(0, 0, -4));
    EXPECT_EQ(box.high, Vec3f(9, 6, 0));
    EXPECT_EQ(boxOf({}).high, Vec3f(0));
}

TEST(SplatFile, readsTheGuitarAndTheDonut) {
    const auto guitar = sharedData("splats/guitar.compressed.ply"), donut = sharedData("splats/donut.inria-sh0.ply");
    if (!guitar || !donut) GTEST_SKIP() << "no shared data with splats/";
    auto g = readSplats(fileBytes(*guitar));
    ASSERT_TRUE(g) << g.error().message;
    EXPECT_EQ(g->format, SplatFormat::CompressedPly);
    EXPECT_EQ(g->splats.count(), 90854u);
    auto d = readSplats(fileBytes(*donut));
    ASSERT_TRUE(d) << d.error().message;
    EXPECT_EQ(d->format, SplatFormat::InriaPly);
    EXPECT_EQ(d->splats.count(), 45624u);
}

}  // namespace
}  // namespace dpl
