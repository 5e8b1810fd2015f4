// SPDX-License-Identifier: Apache-2.0
// Runs the frame's MSL kernels on the CPU, from skinning to the sorted list and the tile fill, in three lane orders. The projected splats
// are blended in double, and both pictures are compared with the referee.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "apps/reference/reference_detail.h"
#include "apps/reference/reference_renderer.h"
#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/half.h"
#include "sdk/visibility/detail.h"
#include "tests/metal/msl_frame.h"
#include "tests/reference/corrective_cases.h"
#include "tests/reference/image_compare.h"
#include "tests/reference/random_avatar.h"
#include "tests/reference/splat_room.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

/** Blends one view front to back in the order of the sorted list, in double. Returns RGB. */
std::vector<double> blend(const MslFrame& f, const Cameraf& camera, uint32_t view, uint32_t viewCount) {
    std::vector<double> rgb(size_t(camera.widthPx) * camera.heightPx * 3, 0), transmittance(size_t(camera.widthPx) * camera.heightPx, 1);
    for (const uint32_t splat : f.sorted) {
        const gpu::ProjectedSplat& p = f.projected[view * f.projected.size() / viewCount + splat];
        const double opacity = (p.opacityAndRadius & 0xFFFF) / 65535.0, radiusX = floatFromHalf(uint16_t(p.opacityAndRadius >> 16)),
                     radiusY = radiusX * std::sqrt(double(p.conicA) / p.conicC),
                     colour[3] = {(p.colour & 2047) / 2047.0, (p.colour >> 11 & 2047) / 2047.0, (p.colour >> 22) / 1023.0};
        for (uint32_t y = 0; y < camera.heightPx; ++y) {
            if (std::abs(y + 0.5 - p.centrePx.y) > radiusY) continue;
            for (uint32_t x = 0; x < camera.widthPx; ++x) {
                const double dx = x + 0.5 - p.centrePx.x, dy = y + 0.5 - p.centrePx.y;
                if (std::abs(dx) > radiusX) continue;
                const double sigma = 0.5 * (p.conicA * dx * dx + p.conicC * dy * dy) + p.conicB * dx * dy;
                const double alpha = std::min(kMaxAlpha, opacity * std::exp(-sigma));
                if (alpha < kMinAlpha) continue;
                double& t = transmittance[size_t(y) * camera.widthPx + x];
                double* pixel = &rgb[(size_t(y) * camera.widthPx + x) * 3];
                for (int c = 0; c < 3; ++c) pixel[c] += alpha * t * colour[c];
                t *= 1 - alpha;
            }
        }
    }
    return rgb;
}

/** Compares frameOf(lane order), the kernels' results, with referenceOf(view), the picture that they must show. */
template <class FrameOf, class ReferenceOf>
void expectKernelsMatchTheReference(const Cameraf (&views)[2], uint32_t splatCount, FrameOf&& frameOf, ReferenceOf&& referenceOf) {
    MslFrame first;
    std::vector<uint32_t> tilePixels;
    for (int order = 0; order < 3; ++order) {
        MslFrame f = frameOf(order);
        ASSERT_GT(f.counts.visible, 1000u);
        EXPECT_EQ(f.counts.drawVertices, 3 * f.counts.visible);
        if (order == 0) first = f;
        const std::vector<uint32_t> pixels = fillTiles(f, views, order);
        if (order == 0) tilePixels = pixels;
        EXPECT_TRUE(pixels == tilePixels) << "lane order " << order;
        EXPECT_TRUE(f.sorted == first.sorted) << "lane order " << order;
        EXPECT_EQ(0, std::memcmp(f.projected.data(), first.projected.data(), f.projected.size() * sizeof(gpu::ProjectedSplat)));
        EXPECT_TRUE(f.sorted == stablySorted(f.compacted)) << "lane order " << order;
        for (size_t i = 1; i < f.compacted.size(); ++i)
            ASSERT_LT(f.compacted[i - 1].splat, f.compacted[i].splat) << "compaction must keep splat order";
    }
    for (uint32_t v = 0; v < 2; ++v) {
        const ReferenceImage want = referenceOf(views[v]);
        const ImageDifference d = compareImages(blend(first, views[v], v, 2), want.rgb);
        std::printf("[   MSL    ] view %u: %u of %u splats, %.1f dB to the reference, max %.4f\n", v, first.counts.visible, splatCount,
                    d.psnrDb, d.maxError);
        EXPECT_GT(coverage(want.alpha), 0.05);
        EXPECT_GE(d.psnrDb, 50);  // not higher because depth keys have 16 bits; equal keys keep splat order
        const ImageDifference filled = compareImages(rgbOfView(tilePixels, views[v], v), want.rgb);
        std::printf("[   MSL    ] view %u, tiles: %.1f dB to the reference, max %.4f\n", v, filled.psnrDb, filled.maxError);
        EXPECT_GE(filled.psnrDb, 50);
    }
}

void expectKernelsMatchTheReference(const AvatarData& uncoded) {
    const AvatarData avatar = codedOnce(uncoded);
    const Pose pose = tubePose(0.9f, 0.4f);
    const Cameraf views[2] = {tubeCamera(96, 96, 0.6f, 1.6f, -0.03f), tubeCamera(96, 96, 0.6f, 1.6f, 0.03f)};
    expectKernelsMatchTheReference(
        views, avatar.splats.count(), [&](int order) { return runFrame(avatar, pose, views, order); },
        [&](const Cameraf& view) { return renderReference(avatar, pose, referenceCamera(view)); });
    const gpu::FrameCounts counts = runFrame(avatar, pose, views, 0).counts;
    EXPECT_EQ(counts.splatsInView, avatar.splats.count()) << "the whole tube is in view";
    EXPECT_LT(counts.splatsFacing, counts.splatsInView) << "single-face splats at the back are gone before projection";
    EXPECT_LE(counts.visible, counts.splatsFacing);
}

TEST(MetalFrame, kernelsOfGeneralSplatsMatchTheReference) {
    const StaticSplatData splats = randomStaticSplats(5, 3000, 3);
    const Cameraf views[2] = {tubeCamera(96, 96, 0.6f, 2.5f, -0.03f), tubeCamera(96, 96, 0.6f, 2.5f, 0.03f)};
    expectKernelsMatchTheReference(
        views, splats.count(), [&](int order) { return runGeneralFrame(splats, views, order); },
        [&](const Cameraf& view) { return renderReference(splats, referenceCamera(view)); });
}

TEST(MetalFrame, kernelsOfGeneralSplatsAtALevelOfDetailMatchTheReference) {
    const StaticSplatData room = splatRoom(1, 9005, 3);
    const Cameraf views[2] = {lookAt({0.27f, 0.2f, 3}, {0.27f, 0.2f, -8}, 96, 96, 80),
                              lookAt({0.33f, 0.2f, 2.6f}, {0.33f, 0.2f, -8}, 96, 96, 80)};
    const std::vector<uint32_t> order = spatialOrder(room.position);
    GeneralDetailSubject subject(measureGroups(room, order), room.count());
    subject.look(views);
    constexpr float kPerPixel = 0.03f;
    const auto referenceOf = [&](const Cameraf& view) {
        return renderReference(reducedSplats(room, {views[0], views[1]}, double(kPerPixel)), referenceCamera(view), {.compensated = false});
    };
    EXPECT_LT(compareImages(referenceOf(views[0]).rgb, renderReference(room, referenceCamera(views[0])).rgb).psnrDb, 45)
        << "the case would prove nothing";
    expectKernelsMatchTheReference(
        views, room.count(), [&](int order) { return runGeneralFrame(room, views, order, subject.detail(kPerPixel)); }, referenceOf);
}

TEST(MetalFrame, kernelsFromSkinningToSortMatchTheReference) {
    expectKernelsMatchTheReference(makeTube({.splatsPerTriangle = 4, .shDegree = 3}));
}

TEST(MetalFrame, kernelsMoveAndLightAnAvatarWithCorrectives) {
    const AvatarData plain = makeTube({.splatsPerTriangle = 4, .shDegree = 3});
    const AvatarData corrected = test::withCorrectives(plain, 2, {.nodes = 20, .offsetM = 0.04f, .light = 6, .reach = 1});
    const ReferenceCamera camera = referenceCamera(tubeCamera(96, 96, 0.6f));
    EXPECT_LT(compareImages(renderReference(plain, tubePose(0.9f, 0.4f), camera).rgb,
                            renderReference(corrected, tubePose(0.9f, 0.4f), camera).rgb)
                  .psnrDb,
              35);
    const auto [darkest, brightest] = std::ranges::minmax(referenceCorrection(corrected, tubePose(0.9f, 0.4f)).light);
    EXPECT_EQ(darkest, 0.2);
    EXPECT_EQ(brightest, 3.0);
    expectKernelsMatchTheReference(corrected);
}

TEST(MetalFrame, kernelsLightAnAvatarWithoutCorrectives) {
    const AvatarData plain = makeTube({.splatsPerTriangle = 4, .shDegree = 3});
    AvatarData lit = plain;
    lit.light.irradiance = {-0.6f, 0.6f, -1.0f, 0.1f, -0.15f, -0.2f, 0.1f, 0.05f};
    const ReferenceCamera camera = referenceCamera(tubeCamera(96, 96, 0.6f));
    EXPECT_LT(
        compareImages(renderReference(plain, tubePose(0.9f, 0.4f), camera).rgb, renderReference(lit, tubePose(0.9f, 0.4f), camera).rgb)
            .psnrDb,
        35);
    expectKernelsMatchTheReference(lit);
}

TEST(MetalFrame, kernelsAtALevelOfDetailMatchTheReference) {
    const AvatarData avatar = codedOnce(makeTube({.splatsPerTriangle = 16, .shDegree = 3}));
    CodedSplats coded = *codeSplats(avatar.mesh, avatar.splats);
    measureDetail(avatar, coded);
    const Pose pose = tubePose(0.9f, 0.4f);
    const Cameraf views[2] = {tubeCamera(96, 96, 0.6f, 1.6f, -0.03f), tubeCamera(96, 96, 0.6f, 1.6f, 0.03f)};
    const DetailSubject subject(avatar, coded);
    const SplatDetail detail{2000, subject.shShare(2000)};
    ASSERT_TRUE(detail.shShare > 0.2f && detail.shShare < 0.95f) << detail.shShare;
    const auto referenceOf = [&](const Cameraf& view) {
        ReferenceScene scene = sceneOf(avatar, pose);
        reduceReference(scene, avatar, coded, 2000);
        return renderReference(scene, referenceCamera(view), {.kappaPx2 = avatar.kappaPx2, .compensated = avatar.compensated});
    };
    EXPECT_LT(compareImages(referenceOf(views[0]).rgb, renderReference(avatar, pose, referenceCamera(views[0])).rgb).psnrDb, 45)
        << "the case would prove nothing";
    expectKernelsMatchTheReference(
        views, avatar.splats.count(), [&](int order) { return runFrame(avatar, pose, views, order, detail); }, referenceOf);
}

}  // namespace
}  // namespace dpl
