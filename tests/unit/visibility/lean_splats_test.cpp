// SPDX-License-Identifier: Apache-2.0
// What a load leaves out when memory is short: SH bands, then the splats that level of detail would leave out first.
#include "sdk/visibility/lean_splats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/sh.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

StaticSplatData ball(uint32_t count, uint32_t shDegree) {
    StaticSplatData s;
    s.shDegree = shDegree;
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (uint32_t i = 0; i < count; ++i) {
        s.position.push_back({normal(random), normal(random), normal(random)});
        s.rotation.emplace_back(1.0f, 0.0f, 0.0f, 0.0f);
        s.scaleM.push_back(Vec3f(0.2f));
        s.opacity.push_back(0.9f);
        for (uint32_t k = 0; k < shCoefficientCount(shDegree) * 3; ++k) s.sh.push_back(float(i) + 0.01f * float(k));
    }
    return s;
}

TEST(LeanSplats, anAvatarKeepsTheShareAndEveryGroup) {
    for (const bool palette : {false, true}) {
        const AvatarData tube = makeTube({.splatsPerTriangle = 20, .rings = 40, .segments = 32, .shDegree = 2});
        const auto coded = codeSplats(tube.mesh, tube.splats, palette);
        ASSERT_TRUE(coded) << coded.error().message;
        const CodedSplats same = leanSplats(tube, *coded, {2, 1});
        EXPECT_EQ(same.place, coded->place);
        EXPECT_EQ(same.sh, coded->sh);
        for (const double share : {0.75, 0.3, 1.0 / 16, 1e-4}) {
            CodedSplats lean = leanSplats(tube, *coded, {1, share});
            EXPECT_EQ(lean.shDegree, 1u);
            EXPECT_EQ(lean.chunks.size(), coded->chunks.size());
            const double groups = 2.0 * double(lean.chunks.size());
            EXPECT_NEAR(lean.count(), std::max(share * coded->count(), groups), 0.03 * coded->count()) << share;
            EXPECT_LT(lean.bytes(), coded->bytes());
            uint32_t next = 0;
            for (size_t i = 0; i < lean.chunks.size(); ++i) {
                const SplatChunk &c = lean.chunks[i], &whole = coded->chunks[i];
                EXPECT_EQ(c.firstSplat, next);
                next += c.splatCount;
                EXPECT_GE(c.scaleMaxM, whole.scaleMaxM);
                EXPECT_LE(c.scaleMaxM, whole.scaleMaxM * 12);
                EXPECT_GE(c.firstTriangle, whole.firstTriangle);
                EXPECT_LE(c.endTriangle, whole.endTriangle);
                for (uint32_t k = c.firstParent;
                     k + 1 < (i + 1 < lean.chunks.size() ? lean.chunks[i + 1].firstParent : lean.parents.size()); ++k)
                    EXPECT_LT(lean.parents[k], lean.parents[k + 1]);
            }
            EXPECT_EQ(next, lean.count());
            EXPECT_EQ(lean.shIndex.size(), palette ? lean.count() : 0);
            EXPECT_EQ(lean.sh.size() % shEntryBytes(1), 0u);
            const SplatData decoded = decodeSplats(lean, tube.mesh.triangles.size());
            EXPECT_EQ(decoded.count(), lean.count());
        }
    }
}

TEST(LeanSplats, bandsThatStayKeepTheirValues) {
    const AvatarData tube = makeTube({.splatsPerTriangle = 4, .rings = 8, .segments = 8, .shDegree = 2});
    const auto coded = codeSplats(tube.mesh, tube.splats);
    ASSERT_TRUE(coded) << coded.error().message;
    const SplatData whole = decodeSplats(*coded, tube.mesh.triangles.size());
    for (const uint32_t degree : {1u, 0u}) {
        const SplatData lean = decodeSplats(leanSplats(tube, *coded, {degree, 1}), tube.mesh.triangles.size());
        const size_t floats = shCoefficientCount(degree) * 3, before = shCoefficientCount(2) * 3;
        ASSERT_EQ(lean.sh.size(), whole.count() * floats);
        for (size_t i = 0; i < whole.count(); ++i)
            for (size_t k = 0; k < floats; ++k) EXPECT_EQ(lean.sh[i * floats + k], whole.sh[i * before + k]);
    }
}

TEST(LeanSplats, generalSplatsGrowToMakeUpForOthers) {
    const StaticSplatData whole = ball(5000, 2);
    const StaticSplatData dull = leanSplats(whole, {0, 1});
    EXPECT_EQ(dull.count(), whole.count());
    EXPECT_EQ(dull.sh.size(), whole.count() * 3u);
    float sum = 0;
    for (size_t i = 0; i < dull.count(); ++i) {
        EXPECT_EQ(dull.sh[i * 3 + 1], dull.sh[i * 3] + 0.01f);  // a splat's own colours
        EXPECT_EQ(dull.scaleM[i], Vec3f(0.2f));
        sum += dull.sh[i * 3];
    }
    EXPECT_NEAR(sum, 5000.0f * 4999 / 2, 1000);
    const StaticSplatData lean = leanSplats(whole, {2, 0.25});
    EXPECT_NEAR(lean.count(), 1250u, 20);
    EXPECT_EQ(lean.sh.size(), lean.count() * 27u);
    EXPECT_GT(lean.scaleM[0].x, 0.25f);
    EXPECT_LE(lean.scaleM[0].x, 0.4f) << "a quarter of the splats, twice as wide, cover as much";
}

TEST(LeanSearch, findsWhatFitsInAFewSteps) {
    for (const double fixed : {0.0, 3e6, 30e6})
        for (const double room : {80e6, 60e6, 40e6, 36e6}) {
            const auto bytes = [&](const Leanness& l) { return uint64_t(fixed + 500000 * l.share * (80 + 30 * l.shDegree)); };
            LeanSearch search(2);
            int steps = 0;
            bool found = true;
            while (found && bytes(search.lean()) > room) found = search.lower(bytes(search.lean()), uint64_t(room)), ++steps;
            ASSERT_TRUE(found);
            EXPECT_LE(steps, 6) << fixed << ' ' << room;
            if (search.lean().share < 1) {
                EXPECT_EQ(search.lean().shDegree, 0u) << "bands go first";
                EXPECT_GT(double(bytes(search.lean())), room * 0.85) << fixed << ' ' << room;
            }
        }
    LeanSearch blind(1);
    int steps = 0;
    while (blind.lower(100, {})) ++steps;
    EXPECT_EQ(steps, 5) << "one band, then 1/2, 1/4, 1/8, 1/16";
    EXPECT_EQ(blind.lean().share, kLeastShare);
    LeanSearch hopeless(0);
    steps = 0;
    while (hopeless.lower(100, 0)) ++steps;
    EXPECT_EQ(steps, 1);
}

}  // namespace
}  // namespace dpl
