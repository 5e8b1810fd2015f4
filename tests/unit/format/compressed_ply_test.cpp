// SPDX-License-Identifier: Apache-2.0
// PlayCanvas compressed PLY: single words, files by splat-transform, and damaged files.
#include "sdk/format/compressed_ply.h"

#include <cstring>

#include "sdk/format/ply.h"
#include "tests/unit/format/splat_files.h"

namespace dpl {
namespace {

using namespace test;

TEST(CompressedPly, decodesWordByWordAsDefined) {
    CompressedPlyByHand f;
    f.words[0] = {0xffffffff, 512u << 20 | 512u << 10 | 1023u, 0xffffffff, 0xff8000ff};  // rotation: w left out, z at its largest
    f.words[1] = {2047u << 21, 1u << 30 | 1023u << 20 | 512u << 10 | 512u, 1023u << 11, 0x00ff0033};  // x left out, w at its largest
    f.words[299] = {0, 3u << 30 | 512u << 20 | 512u << 10 | 0u, 0, 0xff00ff00};                       // z left out, y at its smallest
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
    // Nine bytes: three each of red, green, blue. 256 bins cover [−4, 4]; the first and the last decode to the ends.
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
    // Tolerances are half a step of each code: positions 1.5 m in 11 or 10 bits; rotations 10 bits; scales e^1.95 in 11 bits; opacities 8
    // bits. SH has 8 bits over [−4, 4].
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
    auto large = changed([](auto& f) { f.ranges[0][9] = 200, f.words[0][2] = 0xffffffff; });
    ASSERT_TRUE(large) << "a scale of e^200";
    EXPECT_EQ(large->splats.count(), 299u);
    const auto renamed = [](const std::string& from, const std::string& to) {
        const Bytes good = CompressedPlyByHand().bytes();
        std::string text(good.begin(), good.end());
        text.replace(text.find(from), from.size(), to);
        return readSplats(std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
    };
    expectRefused(renamed("uint packed_scale", "uint backed_scale"), "no scales", Code::CorruptData, "packed_scale");
    expectRefused(renamed("uint packed_scale", "float packed_scale"), "scales as floats", Code::Unsupported, "'packed_scale' of element");
    expectRefused(renamed("float max_z", "float most_z"), "half a range", Code::CorruptData, "max_z");
    expectRefused(renamed("float max_b", "float most_b"), "half a range of colours", Code::CorruptData, "max_b");
    expectRefused(renamed("uchar f_rest_8", "uchar g_rest_8"), "eight SH bytes", Code::CorruptData, "8 f_rest");
    expectRefused(renamed("element vertex", "element vertices"), "no vertices", Code::CorruptData, "'vertex'");
    expectRefused(renamed("float min_x", "list uchar int min_x"), "a list", Code::Unsupported, "list");
    expectRefused(renamed("binary_little_endian", "ascii"), "an ASCII file", Code::Unsupported, "binary");
}

TEST(CompressedPly, truncatedAndFlippedFilesDoNoHarm) {
    expectSturdy(pinned("splats.compressed.ply"));
}

}  // namespace
}  // namespace dpl
