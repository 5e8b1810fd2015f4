// SPDX-License-Identifier: Apache-2.0
// Tests of doppel pack: the SH palette, the pictures that judge a candidate, and the search.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "reconstruction/output/package/pack.h"
#include "reconstruction/output/package/pack_pictures.h"
#include "reconstruction/output/package/sh_palette.h"
#include "sdk/format/avatar_file.h"
#include "sdk/math/sh.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

/** A tube whose values are already rounded by the codec, so that writing and reading it changes nothing. */
AvatarData codedTube(TubeOptions o = {.splatsPerTriangle = 6, .rings = 10, .shDegree = 1, .colourSpread = 0.3f}, bool correctives = false) {
    AvatarData a = makeTube(o);
    if (correctives) a = test::withCorrectives(a, 3, {.modes = 6, .nodes = 20});
    sortSplats(a);
    return *decodedAvatar(a);
}

std::set<std::vector<float>> rowsOf(const SplatData& s) {
    const size_t stride = shCoefficientCount(s.shDegree) * 3;
    std::set<std::vector<float>> rows;
    for (size_t i = 0; i < s.count(); ++i)
        rows.insert({s.sh.begin() + ptrdiff_t(i * stride + 3), s.sh.begin() + ptrdiff_t((i + 1) * stride)});
    return rows;
}

TEST(ShPalette, keepsAtMostMaxEntriesRowsAndEverySplatHasTheNearest) {
    for (uint32_t degree = 1; degree <= 3; ++degree) {
        const AvatarData before = codedTube({.splatsPerTriangle = 6, .rings = 10, .shDegree = degree});
        SplatData s = before.splats;
        Jobs jobs(2);
        auto report = paletteSh(s, {.maxEntries = 64}, jobs);
        ASSERT_TRUE(report) << report.error().message;
        const auto rows = rowsOf(s);
        EXPECT_EQ(rows.size(), report->entries);
        EXPECT_LE(rows.size(), 64u);
        EXPECT_GE(rows.size(), 48u);
        const size_t stride = shCoefficientCount(degree) * 3;
        double squares = 0, weights = 0;
        for (size_t i = 0; i < s.count(); ++i) {
            const auto distance = [&](const float* row) {
                double d = 0;
                for (size_t k = 3; k < stride; ++k) d += std::pow(double(row[k - 3]) - before.splats.sh[i * stride + k], 2);
                return d;
            };
            const double own = distance(s.sh.data() + i * stride + 3);
            for (const auto& row : rows) ASSERT_LE(own, distance(row.data()) * (1 + 1e-5) + 1e-9) << "splat " << i << " has a nearer row";
            for (size_t k = 0; k < 3; ++k) ASSERT_EQ(s.sh[i * stride + k], before.splats.sh[i * stride + k]);
            const double weight = double(s.opacity[i]) * s.scaleM[i].x * s.scaleM[i].y;
            squares += weight * own, weights += weight;
        }
        // The reported error, computed from the definition in the header.
        EXPECT_NEAR(report->rmsLevels, 255 * std::sqrt(squares / weights / (12 * 3.14159265358979)), 1e-6 * report->rmsLevels);
    }
}

TEST(ShPalette, moreEntriesMeanLessErrorAndAnErrorBudgetStopsEarly) {
    const AvatarData a = codedTube();
    Jobs jobs(2);
    double last = 1e9;
    for (const uint32_t entries : {1u, 8u, 64u, 512u}) {
        SplatData s = a.splats;
        const ShPaletteReport report = *paletteSh(s, {.maxEntries = entries}, jobs);
        EXPECT_LT(report.rmsLevels, last * 0.95) << entries;
        last = report.rmsLevels;
    }
    SplatData s = a.splats;
    const ShPaletteReport enough = *paletteSh(s, {.maxEntries = 512, .maxRmsLevels = 2 * last}, jobs);
    EXPECT_LE(enough.rmsLevels, 2 * last);
    EXPECT_LT(enough.entries, 512u);
}

TEST(ShPalette, isTheSameOnAnyNumberOfThreadsAndSurvivesTheFile) {
    const AvatarData a = codedTube();
    std::vector<uint8_t> first;
    for (const uint32_t threads : {1u, 3u}) {
        Jobs jobs(threads);
        AvatarData packed = a;
        ASSERT_TRUE(paletteSh(packed.splats, {.maxEntries = 100}, jobs));
        auto bytes = writeAvatar(packed, {.shPalette = true});
        ASSERT_TRUE(bytes) << bytes.error().message;
        if (first.empty()) first = *bytes;
        EXPECT_TRUE(*bytes == first);
        // The codec scales by the largest row in use. Here that row is used, so nothing is lost beyond rounding.
        const AvatarData back = *readAvatar(*bytes);
        for (size_t k = 0; k < back.splats.sh.size(); ++k)
            if (k % 12 >= 3) {
                ASSERT_NEAR(back.splats.sh[k], packed.splats.sh[k], 1e-6);
            }
    }
}

TEST(ShPalette, refusesImpossibleSizesAndLeavesDegreeZeroAlone) {
    Jobs jobs(1);
    SplatData s = codedTube({.splatsPerTriangle = 1, .rings = 2, .shDegree = 0}).splats;
    EXPECT_EQ(paletteSh(s, {}, jobs)->entries, 0u);
    EXPECT_FALSE(paletteSh(s, {.maxEntries = 0}, jobs));
    EXPECT_FALSE(paletteSh(s, {.maxEntries = 65537}, jobs));
}

TEST(PackPictures, equalAvatarsHaveNoErrorAndImportantSplatsCauseMost) {
    const AvatarData a = codedTube();
    Jobs jobs(2);
    const PackPictures pictures(a, 8, 1, jobs);
    const PackError same = pictures.compare(a);
    EXPECT_EQ(same.squares, 0);
    EXPECT_GT(same.values, 0.05 * same.allValues) << "the pictures show the avatar";
    EXPECT_LT(same.values, 0.95 * same.allValues) << "and background";
    const std::vector<float> importance = pictures.importance(a);
    ASSERT_EQ(importance.size(), a.splats.count());
    // Removing the most important splat must change the pictures much more than removing the least important one.
    const auto without = [&](size_t i) {
        AvatarData b = a;
        b.splats.opacity[i] = 0;
        return pictures.compare(b).squares;
    };
    const size_t most = size_t(std::max_element(importance.begin(), importance.end()) - importance.begin());
    const size_t least = size_t(std::min_element(importance.begin(), importance.end()) - importance.begin());
    EXPECT_GT(without(most), 20 * without(least));
}

TEST(Pack, meetsASizeAndStaysOnTheCurve) {
    const AvatarData a = codedTube({.splatsPerTriangle = 6, .rings = 10, .shDegree = 2, .colourSpread = 0.3f}, true);
    const uint64_t whole = writeAvatar(a)->size();
    Jobs jobs(2);
    auto packed = packToLimits(a, {.maxBytes = whole * 6 / 10}, {.pictures = 6}, jobs);
    ASSERT_TRUE(packed) << packed.error().message;
    EXPECT_LE(packed->file.size(), whole * 6 / 10);
    ASSERT_GE(packed->curve.size(), 2u);
    EXPECT_EQ(packed->curve.back().bytes, packed->file.size());
    for (size_t i = 1; i < packed->curve.size(); ++i) EXPECT_LT(packed->curve[i].bytes, packed->curve[i - 1].bytes);
    // The PSNR in the curve is that of the written file.
    const AvatarData back = *readAvatar(packed->file);
    const PackPictures pictures(a, 6, 1, jobs);
    EXPECT_NEAR(pictures.compare(back).psnrDb(), packed->curve.back().psnrDb, 1e-9);
    EXPECT_EQ(back.evidence.back().part, "packed");
    auto again = packToLimits(a, {.maxBytes = whole * 6 / 10}, {.pictures = 6}, jobs);
    EXPECT_TRUE(again && again->file == packed->file) << "same seed, same bytes";
}

TEST(Pack, aFileWithAPaletteStartsAsItIsAndItsPaletteShrinks) {
    AvatarData avatar = codedTube({.splatsPerTriangle = 8, .rings = 12, .shDegree = 1});
    Jobs jobs(2);
    ASSERT_TRUE(paletteSh(avatar.splats, {.maxEntries = 300}, jobs));
    const auto file = writeAvatar(avatar, {.shPalette = true});
    ASSERT_TRUE(file) << file.error().message;
    const auto decoded = readAvatar(*file);
    ASSERT_TRUE(decoded) << decoded.error().message;
    const auto packed = packToLimits(*decoded, {.maxBytes = file->size() * 40 / 100}, {.seed = 1, .pictures = 4}, jobs);
    ASSERT_TRUE(packed) << packed.error().message;
    EXPECT_EQ(packed->curve[0].bytes, file->size());
    EXPECT_EQ(packed->curve[0].shEntries, rowsOf(avatar.splats).size());
    EXPECT_LT(packed->curve.back().shEntries, packed->curve[0].shEntries) << "the ladder of SH must not stop at the palette of the file";
}

TEST(Pack, entropyCodesFirstThenTakesBitsAndAPackedFileGoesOnFromThere) {
    const AvatarData a = codedTube({.splatsPerTriangle = 8, .rings = 20, .shDegree = 0, .colourSpread = 0.3f});
    Jobs jobs(2);
    auto packed = packToLimits(a, {.minPsnrDb = 44}, {.pictures = 4}, jobs);
    ASSERT_TRUE(packed) << packed.error().message;
    ASSERT_GE(packed->curve.size(), 4u);
    EXPECT_FALSE(packed->curve[0].compact);
    EXPECT_EQ(packed->curve[0].bits, SplatBits());
    size_t bitMoves = 0;
    for (size_t i = 1; i < packed->curve.size(); ++i) bitMoves += packed->curve[i].bits != packed->curve[i - 1].bits;
    EXPECT_GE(bitMoves, 3u);
    const AvatarInfo info = *inspectAvatar(packed->file);
    EXPECT_EQ(info.splatEncoding, 3u);
    EXPECT_EQ(info.bits, packed->curve.back().bits);
    // Packing the result again starts at its own size and bits, and then takes more bits away.
    const AvatarData again = *readAvatar(packed->file);
    auto further = packToLimits(again, {.minPsnrDb = 40}, {.pictures = 4, .compact = true}, jobs);
    ASSERT_TRUE(further) << further.error().message;
    EXPECT_EQ(further->curve[0].bytes, packed->file.size());
    EXPECT_EQ(further->curve[0].bits, info.bits);
    EXPECT_TRUE(std::isinf(further->curve[0].psnrDb)) << "nothing was lost by reading and writing";
    EXPECT_LT(further->file.size(), packed->file.size());
}

TEST(Pack, goesAsFarAsTheLossAllows) {
    const AvatarData a = codedTube();
    Jobs jobs(2);
    auto strict = packToLimits(a, {.minPsnrDb = 42}, {.pictures = 6}, jobs),
         loose = packToLimits(a, {.minPsnrDb = 30}, {.pictures = 6}, jobs);
    ASSERT_TRUE(strict && loose);
    EXPECT_GE(strict->curve.back().psnrDb, 42);
    EXPECT_GE(loose->curve.back().psnrDb, 30);
    EXPECT_LT(strict->file.size(), strict->curve[0].bytes * 9 / 10);
    EXPECT_LT(loose->file.size(), strict->file.size());
    EXPECT_NE(curveAsText(loose->curve).find("palette of"), std::string::npos);
}

TEST(Pack, statesTheNearestResultWhenLimitsCannotBeMet) {
    const AvatarData a = codedTube({.splatsPerTriangle = 2, .rings = 6, .shDegree = 1});
    Jobs jobs(2);
    auto tooSmall = packToLimits(a, {.maxBytes = 1000}, {.pictures = 4}, jobs);
    ASSERT_FALSE(tooSmall);
    EXPECT_EQ(int(tooSmall.error().code), int(Code::InvalidArgument));
    EXPECT_NE(tooSmall.error().message.find("the smallest"), std::string::npos) << tooSmall.error().message;
    auto both = packToLimits(a, {.maxBytes = 1000, .minPsnrDb = 40}, {.pictures = 4}, jobs);
    ASSERT_FALSE(both);
    EXPECT_NE(both.error().message.find("the nearest"), std::string::npos) << both.error().message;
    EXPECT_FALSE(packToLimits(a, {}, {}, jobs));
    test::HeardTask task(1);
    const TaskScope scope(&task);
    auto stopped = packToLimits(a, {.minPsnrDb = 40}, {.pictures = 4}, jobs);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(int(stopped.error().code), int(Code::Cancelled));
}

}  // namespace
}  // namespace dpl
