// SPDX-License-Identifier: Apache-2.0
// Runs the frame's MSL kernels on the CPU, from skinning to the sorted list and the tile fill, in three lane orders. The projected splats
// are blended in double, and both pictures are compared with the referee.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "apps/reference/reference_detail.h"
#include "apps/reference/reference_mesh.h"
#include "apps/reference/reference_renderer.h"
#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/half.h"
#include "sdk/math/scene_depth.h"
#include "sdk/render/avatar_upload.h"
#include "sdk/render/passes/scan.h"
#include "sdk/render/passes/tiles.h"
#include "sdk/visibility/detail.h"
#include "tests/reference/corrective_cases.h"
#include "tests/reference/image_compare.h"
#include "tests/reference/random_avatar.h"
#include "tests/reference/random_scene_depth.h"
#include "tests/reference/splat_room.h"
#include "tests/unit/render/palette_of.h"
#include "tests/unit/render/tube_avatar.h"

#define DPL_MSL(name) bool name(void* const* buffers, unsigned groups, int order)
DPL_MSL(msl_skin);
DPL_MSL(msl_skin_corrected);
DPL_MSL(msl_triangles_stereo);
DPL_MSL(msl_mesh_depth);
DPL_MSL(msl_chunks_mark);
DPL_MSL(msl_chunks_list);
DPL_MSL(msl_project_sh3_stereo);
DPL_MSL(msl_project_general_stereo);
DPL_MSL(msl_colour_general_sh3_stereo);
DPL_MSL(msl_scan_totals);
DPL_MSL(msl_scan_places);
DPL_MSL(msl_scan_sums);
DPL_MSL(msl_compact_masks);
DPL_MSL(msl_compact_args);
DPL_MSL(msl_compact_scatter);
DPL_MSL(msl_sort_count);
DPL_MSL(msl_sort_count_packed);
DPL_MSL(msl_sort_scatter_pack);
DPL_MSL(msl_sort_scatter_packed);
DPL_MSL(msl_sort_scatter);
DPL_MSL(msl_tiles_runs_stereo);
DPL_MSL(msl_tiles_args_spans);
DPL_MSL(msl_tiles_spans_stereo);
DPL_MSL(msl_tiles_count);
DPL_MSL(msl_tiles_args_entries);
DPL_MSL(msl_tiles_entries);
DPL_MSL(msl_tiles_fill_depth);
DPL_MSL(msl_tiles_fill_depth_scene);
DPL_MSL(msl_tiles_fill_depth_four);
DPL_MSL(msl_tiles_fill_depth_scene_four);

namespace dpl {
namespace {

/** Results of a frame's kernels. */
struct MslFrame {
    std::vector<gpu::ProjectedSplat> projected;
    std::vector<gpu::SortPair> compacted;
    std::vector<uint32_t> sorted;
    gpu::FrameCounts counts{};
};

uint32_t groupsFor(size_t count, uint32_t size) {
    return uint32_t((count + size - 1) / size);
}

/** Dispatches a kernel. Buffers are in binding order; push constants come last. */
template <class Push>
void run(bool (*kernel)(void* const*, unsigned, int), uint32_t groups, int order, std::vector<void*> buffers, Push push) {
    buffers.push_back(&push);
    ASSERT_TRUE(kernel(buffers.data(), groups, order)) << "lanes left a barrier alone";
}

/** Sets the counts that compact.args writes for passes over runs of kRun survivors. */
void setRuns(gpu::FrameCounts& counts) {
    counts.runs = groupsFor(counts.visible, gpu::kRun);
    counts.runGroupsX = groupsFor(counts.runs, gpu::kRunGroup);
}

void scan(gpu::FrameCounts& counts, std::vector<uint32_t>& table, std::vector<uint32_t>& sums, std::vector<uint32_t>& places,
          const gpu::RowScanPush& push, uint32_t rows, int order) {
    run(msl_scan_totals, rows, order, {&counts, table.data(), sums.data()}, push);
    run(msl_scan_sums, 1, order, {sums.data()}, gpu::ScanPush{push.firstSum, rows * gpu::kRowScanGroup});
    run(msl_scan_places, rows, order, {&counts, table.data(), sums.data(), places.data()}, push);
}

/** Sorts (key, splat) pairs with the sort kernels and returns the splats in order. */
std::vector<uint32_t> sortPairs(std::vector<gpu::SortPair> pairs, gpu::FrameCounts& counts, int order, uint32_t rounds = gpu::kSortRounds) {
    std::vector<gpu::SortPair> other(pairs.size() + 1);
    const size_t cells = gpu::kSortDigits * counts.runs;
    std::vector<uint32_t> sums(scanSumWords(gpu::kSortDigits)), places(cells, 0xCDCDCDCD);
    void *from = pairs.data(), *to = other.data();
    for (uint32_t left = rounds; left-- > 0;) {
        const gpu::SortPush push{(rounds - 1 - left) * gpu::kSortDigitBits};
        std::vector<uint32_t> table(cells);
        run(left == 0 ? msl_sort_count_packed : msl_sort_count, counts.runGroupsX, order, {&counts, from, table.data()}, push);
        scan(counts, table, sums, places, {}, gpu::kSortDigits, order);
        run(left == 0   ? msl_sort_scatter_packed
            : left == 1 ? msl_sort_scatter_pack
                        : msl_sort_scatter,
            counts.runGroupsX, order, {&counts, from, places.data(), to}, push);
        std::swap(from, to);
    }
    std::vector<uint32_t> sorted(pairs.size());
    if (!sorted.empty()) std::memcpy(sorted.data(), from, sorted.size() * 4);
    return sorted;
}

std::vector<uint32_t> stablySorted(std::vector<gpu::SortPair> pairs) {
    std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
    std::vector<uint32_t> splats;
    for (const gpu::SortPair& pair : pairs) splats.push_back(pair.splat);
    return splats;
}

/** Compacts the survivors that projection marked in the visibility buffer and sorts them. */
void compactAndSort(MslFrame& out, std::vector<uint32_t>& visibility, uint32_t groups, uint32_t splats, int order, uint32_t rounds) {
    FrameIds ids;
    ids.allGroups = groups;
    std::vector<uint32_t> survivors(ids.survivorWords(), 0xCDCDCDCD);
    out.compacted.resize(splats);
    run(msl_compact_masks, groupsFor(groups, gpu::kCompactGroup), order, {visibility.data(), survivors.data()}, gpu::MaskPush{groups});
    run(msl_scan_sums, 1, order, {survivors.data()}, gpu::ScanPush{ids.firstSum(), groups});
    run(msl_compact_args, 1, order, {survivors.data(), &out.counts}, gpu::ArgsPush{groups, (1u << (rounds * gpu::kSortDigitBits)) - 1, 1});
    const gpu::FrameCounts want = [&] {
        auto counts = out.counts;
        setRuns(counts);
        return counts;
    }();
    EXPECT_EQ(out.counts.runGroupsX, want.runGroupsX);
    run(msl_compact_scatter, groupsFor(groups * gpu::kMaskWords, gpu::kCompactGroup), order,
        {visibility.data(), survivors.data(), &out.counts, out.compacted.data()},
        gpu::CompactPush{groups, (1u << (rounds * gpu::kSortDigitBits)) - 1, 1, {groups}});
    out.compacted.resize(out.counts.visible);
    out.sorted = sortPairs(out.compacted, out.counts, order, rounds);
}

/** The visibility buffer of a frame, filled with garbage because no kernel may read it before writing. */
std::vector<uint32_t> visibilityOf(uint32_t groups, uint32_t splats) {
    FrameIds ids;
    ids.allGroups = groups, ids.splatCount = splats;
    return std::vector<uint32_t>(ids.visibilityWords(), 0xCDCDCDCD);
}

MslFrame runGeneralFrame(const StaticSplatData& splats, std::span<const Cameraf> views, int order, const GeneralDetail& detail = {}) {
    const std::vector<uint32_t> inSpace = spatialOrder(splats.position);
    std::vector<gpu::uvec4> records = packSplats(splats, inSpace, measureGroups(splats, inSpace));
    gpu::FrameData frame = packFrame(splatSetOf(splats), views);
    packGeneralDetail(detail, frame);
    const uint32_t count = splats.count(), viewCount = uint32_t(views.size()), groups = groupsFor(count, gpu::kSplatGroup);
    std::vector<uint32_t> visibility = visibilityOf(groups, count);
    std::vector<gpu::uvec4> sh = packSh(splats, inSpace);
    MslFrame out;
    out.projected.resize(size_t(count) * viewCount);
    run(msl_project_general_stereo, groups, order, {&frame, records.data(), out.projected.data(), visibility.data(), &out.counts},
        gpu::SplatPush{count, groups, 0, 0, 0});
    run(msl_colour_general_sh3_stereo, groups, order, {&frame, records.data(), sh.data(), out.projected.data()}, gpu::ColourPush{count, 0});
    compactAndSort(out, visibility, groups, count, order, gpu::kWideSortRounds);
    return out;
}

MslFrame runFrame(const AvatarData& avatar, const Pose& pose, std::span<const Cameraf> views, int order, const SplatDetail& detail = {},
                  uint32_t samples = 1) {
    CodedSplats coded = *codeSplats(avatar.mesh, avatar.splats);
    measureDetail(avatar, coded);
    AvatarRecords records = packAvatar(avatar, coded);
    gpu::FrameData frame =
        packFrame(splatSetOf(avatar, coded), views, samples, detail, DetailSubject(avatar, coded).largestGrowth(detail.perM2));
    const bool corrected = !avatar.correctives.empty();
    std::vector<gpu::vec4> palette = paletteOf(avatar, pose, pose);
    MslFrame out;
    const uint32_t splats = coded.count(), viewCount = uint32_t(views.size());
    std::vector<gpu::PosedVertex> posed(avatar.mesh.restPositions.size());
    std::vector<gpu::TriangleFrame> frames(records.triangles.size());
    const uint32_t groups = 2 * uint32_t(coded.chunks.size());
    std::vector<uint32_t> visibility = visibilityOf(groups, splats);
    out.projected.resize(size_t(splats) * viewCount);
    void* vertices = corrected ? static_cast<void*>(records.correctedVertices.data()) : records.vertices.data();
    run(corrected ? msl_skin_corrected : msl_skin, groupsFor(posed.size(), gpu::kVertexGroup), order,
        {&frame, palette.data(), vertices, posed.data(), &out.counts},
        gpu::VertexPush{uint32_t(posed.size()), uint32_t(3 * avatar.joints.size()), 0});
    run(msl_triangles_stereo, groupsFor(frames.size(), gpu::kVertexGroup), order,
        {&frame, records.triangles.data(), posed.data(), frames.data(), &out.counts}, gpu::TrianglePush{uint32_t(frames.size())});
    gpu::CodesPush push = records.where;
    push.groupCount = push.allGroups = groups;
    run(msl_chunks_mark, groupsFor(groups, gpu::kChunkGroup), order, {records.codes.data(), frames.data(), visibility.data()}, push);
    run(msl_chunks_list, 1, order, {visibility.data(), &out.counts}, gpu::ChunkPush{groups, groups, 0});
    run(msl_project_sh3_stereo, out.counts.chunkGroupsX, order,
        {&frame, records.codes.data(), frames.data(), out.projected.data(), visibility.data()}, push);
    compactAndSort(out, visibility, groups, splats, order, gpu::kSortRounds);
    return out;
}

/** Runs the tile passes on a sorted frame. Returns 8-bit colour of all views, then the depth sums. farthestSeenM: depth limits from the
 * app's scene for all views, or empty without a scene. */
std::vector<uint32_t> fillTiles(MslFrame& f, std::span<const Cameraf> views, int order, std::span<const float> farthestSeenM = {},
                                uint32_t samples = 1) {
    FrameIds ids;
    ids.viewCount = uint32_t(views.size()), ids.widthPx = views[0].widthPx, ids.heightPx = views[0].heightPx, ids.depth = true;
    ids.splatCount = uint32_t(f.projected.size()) / ids.viewCount;
    ids.sceneDepth = !farthestSeenM.empty(), ids.samples = samples;
    const auto tiles = planTiles(ids, {.maxBindingBytes = 128u << 20, .maxGroups = 65535});
    EXPECT_TRUE(tiles);
    const gpu::TilePush& push = tiles->push;
    std::vector<uint32_t> table(tiles->tableWords), sums(tiles->sumWords), places(tiles->tableWords, 0xCDCDCDCD),
        spans(tiles->spanBytes / 4), entries(tiles->entryBytes / 4), pixels(tiles->pixelBytes / 4);
    run(msl_tiles_runs_stereo, f.counts.runGroupsX, order, {f.sorted.data(), f.projected.data(), &f.counts, table.data()}, push);
    scan(f.counts, table, sums, places, {0, push.firstRunTable, push.firstSpanSum}, tiles->rows(), order);
    run(msl_tiles_args_spans, 1, order, {sums.data(), &f.counts, places.data()}, push);
    run(msl_tiles_spans_stereo, f.counts.spanGroupsX, order, {f.sorted.data(), f.projected.data(), places.data(), spans.data()}, push);
    run(msl_tiles_count, f.counts.rowGroupsX, order, {spans.data(), sums.data(), table.data()}, push);
    scan(f.counts, table, sums, places, {push.columns * gpu::kTileSegments, push.firstTileTable, push.firstEntrySum}, tiles->rows(), order);
    run(msl_tiles_args_entries, 1, order, {sums.data(), &f.counts}, push);
    EXPECT_EQ(f.counts.drawInstances, 0u) << "the quads have nothing to do";
    EXPECT_EQ(f.counts.tilesOverflowed, 0u);
    EXPECT_GT(f.counts.tileEntries, f.counts.visible);
    run(msl_tiles_entries, f.counts.entryGroupsX, order, {spans.data(), sums.data(), places.data(), entries.data()}, push);
    if (ids.sceneDepth) std::memcpy(pixels.data() + push.firstScene, farthestSeenM.data(), farthestSeenM.size_bytes());
    const auto fill = samples == 1     ? ids.sceneDepth ? msl_tiles_fill_depth_scene : msl_tiles_fill_depth
                      : ids.sceneDepth ? msl_tiles_fill_depth_scene_four
                                       : msl_tiles_fill_depth_four;
    run(fill, f.counts.fillGroupsX, order, {places.data(), entries.data(), f.projected.data(), pixels.data()}, push);
    return pixels;
}

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
        std::vector<double> tiles;
        const size_t pixels = size_t(views[v].widthPx) * views[v].heightPx;
        for (size_t i = v * pixels; i < (v + 1) * pixels; ++i)
            for (int c = 0; c < 3; ++c) tiles.push_back((tilePixels[i] >> 8 * c & 255) / 255.0);
        const ImageDifference filled = compareImages(tiles, want.rgb);
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

TEST(MetalFrame, correctedVerticesAreTheRefereesToAThousandthOfTheirRange) {
    expectCorrectivesMatch("Metal", [](const AvatarData& avatar, const Pose& pose, bool skinned) {
        const CodedSplats coded = *codeSplats(avatar.mesh, avatar.splats);
        AvatarRecords records = packAvatar(avatar, coded);
        const Cameraf camera = tubeCamera(16, 16, 0);
        gpu::FrameData frame = packFrame(splatSetOf(avatar, coded), {&camera, 1});
        std::vector<gpu::vec4> palette = paletteOf(avatar, skinned ? pose : Pose::rest(avatar.joints.size()), pose);
        gpu::FrameCounts counts{};
        std::vector<Vec4f> posed(avatar.mesh.restPositions.size());
        run(msl_skin_corrected, groupsFor(posed.size(), gpu::kVertexGroup), 0,
            {&frame, palette.data(), records.correctedVertices.data(), posed.data(), &counts},
            gpu::VertexPush{uint32_t(posed.size()), uint32_t(3 * avatar.joints.size()), 0});
        return posed;
    });
}

TEST(MetalFrame, tilesBehindASceneMatchTheReference) {
    const AvatarData avatar = codedOnce(makeTube({.splatsPerTriangle = 4, .shDegree = 3}));
    const Pose pose = tubePose(0.9f, 0.4f);
    const Cameraf views[2] = {tubeCamera(93, 91, 0.6f, 1.6f, -0.03f), tubeCamera(93, 91, 0.6f, 1.6f, 0.03f)};
    const std::vector<float> scenes[2] = {randomSceneDepth(1, 93, 91, 1.6f), randomSceneDepth(2, 93, 91, 1.6f)};
    std::vector<float> seen;
    for (const auto& scene : scenes) std::transform(scene.begin(), scene.end(), std::back_inserter(seen), farthestSeenM);
    std::vector<uint32_t> first;
    for (int order = 0; order < 3; ++order) {
        MslFrame f = runFrame(avatar, pose, views, order), free = f;
        const std::vector<uint32_t> pixels = fillTiles(f, views, order, seen);
        if (order == 0) first = pixels;
        EXPECT_TRUE(pixels == first) << "lane order " << order;
        const std::vector<uint32_t> plain = fillTiles(free, views, order);
        free = runFrame(avatar, pose, views, order);
        const std::vector<uint32_t> empty = fillTiles(free, views, order, std::vector<float>(seen.size(), INFINITY));
        EXPECT_TRUE(std::equal(plain.begin(), plain.end(), empty.begin())) << "an empty scene changes nothing";
    }
    for (size_t v = 0; v < 2; ++v) {
        const ReferenceImage want = renderReference(avatar, pose, referenceCamera(views[v]), scenes[v]);
        EXPECT_LT(compareImages(renderReference(avatar, pose, referenceCamera(views[v])).rgb, want.rgb).psnrDb, 30)
            << "the scene hides nothing: this case would prove nothing";
        std::vector<double> rgb;
        for (size_t i = v * 93 * 91; i < (v + 1) * 93 * 91; ++i)
            for (int c = 0; c < 3; ++c) rgb.push_back((first[i] >> 8 * c & 255) / 255.0);
        const ImageDifference d = compareImages(rgb, want.rgb);
        std::printf("[   MSL    ] view %zu behind a scene: %.1f dB to the reference, max %.4f\n", v, d.psnrDb, d.maxError);
        EXPECT_GE(d.psnrDb, 50);
    }
}

TEST(MetalFrame, tilesOfFourSamplesMatchTheReferenceFreeAndBehindAScene) {
    AvatarData data = makeTube({.splatsPerTriangle = 4, .shDegree = 3});
    data.trainedPixelM = 1e-4f, data.kappaPx2 = 1 / 12.0f;
    const AvatarData avatar = codedOnce(data);
    const Pose pose = tubePose(0.9f, 0.4f);
    const Cameraf views[2] = {tubeCamera(93, 91, 0.6f, 1.6f, -0.03f), tubeCamera(93, 91, 0.6f, 1.6f, 0.03f)};
    ASSERT_TRUE(referenceFourSamples(avatar, pose, referenceCamera(views[0])));
    const std::vector<float> scenes[2] = {randomSceneDepth(1, 93, 91, 1.6f), randomSceneDepth(2, 93, 91, 1.6f)};
    std::vector<float> seen;
    for (const auto& scene : scenes) std::transform(scene.begin(), scene.end(), std::back_inserter(seen), farthestSeenM);
    for (const bool behind : {false, true}) {
        std::vector<uint32_t> first;
        for (int order = 0; order < 3; ++order) {
            MslFrame f = runFrame(avatar, pose, views, order, {}, 4);
            const std::vector<uint32_t> pixels =
                fillTiles(f, views, order, behind ? std::span<const float>(seen) : std::span<const float>(), 4);
            if (order == 0) first = pixels;
            EXPECT_TRUE(pixels == first) << "lane order " << order;
        }
        for (size_t v = 0; v < 2; ++v) {
            const ReferenceImage want = renderReference(avatar, pose, referenceCamera(views[v]), behind ? scenes[v] : std::vector<float>());
            std::vector<double> rgb;
            for (size_t i = v * 93 * 91; i < (v + 1) * 93 * 91; ++i)
                for (int c = 0; c < 3; ++c) rgb.push_back((first[i] >> 8 * c & 255) / 255.0);
            const ImageDifference d = compareImages(rgb, want.rgb);
            std::printf("[   MSL    ] view %zu, four samples%s: %.1f dB to the reference, max %.4f\n", v, behind ? " behind a scene" : "",
                        d.psnrDb, d.maxError);
            EXPECT_GE(d.psnrDb, 50);
            EXPECT_GT(coverage(want.alpha), 0.05);
        }
    }
}

TEST(MetalFrame, meshDepthMatchesTheReference) {
    const AvatarData avatar = makeTube({.splatsPerTriangle = 1});
    const Pose pose = tubePose(0.9f, 0.4f);
    std::vector<Mat3x4f> joints;
    jointTransforms(avatar.joints, pose, joints);
    AvatarRecords records = packAvatar(avatar, *codeSplats(avatar.mesh, avatar.splats));
    std::vector<gpu::vec4> palette(paletteSize(avatar));
    std::vector<gpu::PosedVertex> posed(avatar.mesh.restPositions.size());
    packPalette(joints, {}, palette);
    for (const float distanceM : {1.6f, 0.2f}) {  // small triangles, and triangles so large that all lanes of a threadgroup share one
        const Cameraf views[2] = {tubeCamera(80, 70, 0.6f, distanceM, -0.03f), tubeCamera(80, 70, 0.6f, distanceM, 0.03f)};
        gpu::FrameData frame = packFrame(splatSetOf(avatar, *codeSplats(avatar.mesh, avatar.splats)), views);
        std::vector<uint32_t> first;
        for (int order = 0; order < 3; ++order) {
            gpu::FrameCounts counts{};
            run(msl_skin, groupsFor(posed.size(), gpu::kVertexGroup), order,
                {&frame, palette.data(), records.vertices.data(), posed.data(), &counts},
                gpu::VertexPush{uint32_t(posed.size()), uint32_t(3 * avatar.joints.size()), 0});
            std::vector<uint32_t> bits(2 * 80 * 70, std::bit_cast<uint32_t>(INFINITY));
            const uint32_t triangles = uint32_t(avatar.mesh.triangles.size());
            run(msl_mesh_depth, groupsFor(triangles, gpu::kVertexGroup), order,
                {&frame, records.triangles.data(), posed.data(), bits.data()}, gpu::MeshDepthPush{triangles, 2, 80, 70});
            if (order == 0) first = bits;
            EXPECT_EQ(bits, first) << "lane order " << order;
        }
        for (size_t v = 0; v < 2; ++v) {
            std::vector<float> depthM(80 * 70);
            for (size_t i = 0; i < depthM.size(); ++i) depthM[i] = std::bit_cast<float>(first[v * depthM.size() + i]);
            std::replace(depthM.begin(), depthM.end(), INFINITY, 0.0f);
            const MeshDepthReport r =
                compareMeshDepth(depthM, referenceSkin(avatar, pose), avatar.mesh.triangles, referenceCamera(views[v]), 0.01, 2e-5);
            EXPECT_EQ(r.wrong, 0u) << r.firstWrong;
            EXPECT_GT(r.covered, depthM.size() / 20);
        }
    }
}

TEST(MetalFrame, sortIsStableAcrossBlocksAndTies) {
    for (uint32_t keys : {1u, 16u, 65536u}) {
        for (int order = 0; order < 3; ++order) {
            gpu::FrameCounts counts{};
            counts.visible = 5001;
            setRuns(counts);
            std::vector<gpu::SortPair> pairs(counts.visible);
            for (uint32_t i = 0; i < counts.visible; ++i) pairs[i] = {(i * 2654435761u >> 7) % keys, i};
            EXPECT_TRUE(sortPairs(pairs, counts, order) == stablySorted(pairs)) << keys << " keys, lane order " << order;
        }
    }
}

}  // namespace
}  // namespace dpl
