// SPDX-License-Identifier: Apache-2.0
// readSplats and its helpers: recognised formats, plain PLY, bounding boxes, the scans of shared/data.
#include "sdk/format/splat_file.h"

#include <algorithm>
#include <cstring>

#include "sdk/format/avatar_file.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/splat_files.h"

namespace dpl {
namespace {

using namespace test;

TEST(SplatFile, isRecognisedByItsContent) {
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
    const size_t body = good.size() - 7 * 14 * 4;  // x y z, dc, opacity, scale, rotation
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
    for (const auto& file : {with(2, 6, NAN), with(2, 8, INFINITY), with(2, 0, INFINITY)}) {  // opacity, scale, place
        ASSERT_TRUE(file);
        EXPECT_EQ(file->splats.count(), 6u) << "a splat without an end is left out";
        EXPECT_NE(file->remarks.notes.at(0).find("splat 2"), std::string::npos);
    }
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
