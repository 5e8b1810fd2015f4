// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/msl_frame.h"

#include <algorithm>
#include <cstring>

#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"
#include "sdk/render/passes/scan.h"
#include "sdk/render/passes/tiles.h"
#include "sdk/visibility/detail.h"
#include "tests/metal/msl_kernels.h"
#include "tests/unit/render/palette_of.h"

namespace dpl {
namespace {

void scan(gpu::FrameCounts& counts, std::vector<uint32_t>& table, std::vector<uint32_t>& sums, std::vector<uint32_t>& places,
          const gpu::RowScanPush& push, uint32_t rows, int order) {
    run(msl_scan_totals, rows, order, {&counts, table.data(), sums.data()}, push);
    run(msl_scan_sums, 1, order, {sums.data()}, gpu::ScanPush{push.firstSum, rows * gpu::kRowScanGroup});
    run(msl_scan_places, rows, order, {&counts, table.data(), sums.data(), places.data()}, push);
}

/** Compacts the survivors that projection marked in the visibility buffer and sorts them. */
void compactAndSort(MslFrame& out, std::vector<uint32_t>& visibility, uint32_t groups, uint32_t splats, int order, uint32_t rounds) {
    FrameIds ids;
    ids.allGroups = groups;
    std::vector<uint32_t> survivors(ids.survivorWords(), 0xCDCDCDCD);
    out.compacted.resize(splats);
    run(msl_compact_masks, groupsFor(groups, gpu::kCompactGroup), order, {visibility.data(), survivors.data()}, gpu::MaskPush{groups});
    run(msl_scan_sums, 1, order, {survivors.data()}, gpu::ScanPush{ids.firstSum(), groups});
    run(msl_compact_args, 1, order, {survivors.data(), &out.counts},
        gpu::ArgsPush{groups, (1u << (rounds * gpu::kSortDigitBits)) - 1, 1, 1});
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
    ids.allGroups = groups, ids.allSplats = splats;
    return std::vector<uint32_t>(ids.visibilityWords(), 0xCDCDCDCD);
}

}  // namespace

void setRuns(gpu::FrameCounts& counts) {
    counts.runs = groupsFor(counts.visible, gpu::kRun);
    counts.runGroupsX = counts.runs;
}

std::vector<uint32_t> sortPairs(std::vector<gpu::SortPair> pairs, gpu::FrameCounts& counts, int order, uint32_t rounds) {
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

MslFrame runGeneralFrame(const StaticSplatData& splats, std::span<const Cameraf> views, int order, const GeneralDetail& detail) {
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

MslFrame runFrame(const AvatarData& avatar, const Pose& pose, std::span<const Cameraf> views, int order, const SplatDetail& detail,
                  uint32_t samples) {
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
        gpu::VertexPush{uint32_t(posed.size()), uint32_t(3 * avatar.joints.size()), firstLightRow(avatar), 0});
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

namespace {

/** Fills from lists of the plan's sizes; where they overflow, by a search. */
std::vector<uint32_t> fillBy(const TilePlan& plan, const FrameIds& ids, MslFrame& f, int order, std::span<const float> farthestSeenM) {
    const gpu::TilePush& push = plan.push;
    std::vector<uint32_t> table(plan.tableWords), sums(plan.sumWords), places(plan.tableWords, 0xCDCDCDCD), spans(plan.spanBytes / 4),
        entries(plan.entryBytes / 4), pixels(plan.pixelBytes / 4);
    run(msl_tiles_runs_stereo, f.counts.runGroupsX, order, {f.sorted.data(), f.projected.data(), &f.counts, table.data()}, push);
    scan(f.counts, table, sums, places, {0, push.firstRunTable, push.firstSpanSum}, plan.rows(), order);
    run(msl_tiles_args_spans, 1, order, {sums.data(), &f.counts, places.data()}, push);
    run(msl_tiles_spans_stereo, f.counts.runGroupsX, order, {f.sorted.data(), f.projected.data(), places.data(), spans.data()}, push);
    run(msl_tiles_count, f.counts.rowGroupsX, order, {spans.data(), sums.data(), table.data()}, push);
    scan(f.counts, table, sums, places, {push.columns * gpu::kTileSegments, push.firstTileTable, push.firstEntrySum}, plan.rows(), order);
    run(msl_tiles_args_entries, 1, order, {sums.data(), &f.counts}, push);
    run(msl_tiles_entries, f.counts.entryGroupsX, order, {spans.data(), sums.data(), places.data(), entries.data()}, push);
    if (ids.sceneDepth) std::memcpy(pixels.data() + push.firstScene, farthestSeenM.data(), farthestSeenM.size_bytes());
    const auto kernel = [&](auto plain, auto scene, auto four, auto sceneFour) {
        return ids.samples == 1 ? ids.sceneDepth ? scene : plain : ids.sceneDepth ? sceneFour : four;
    };
    const auto fill = kernel(msl_tiles_fill_depth, msl_tiles_fill_depth_scene, msl_tiles_fill_depth_four, msl_tiles_fill_depth_scene_four);
    const auto search =
        kernel(msl_tiles_search_depth, msl_tiles_search_depth_scene, msl_tiles_search_depth_four, msl_tiles_search_depth_scene_four);
    run(fill, f.counts.fillGroupsX, order, {places.data(), entries.data(), f.projected.data(), pixels.data()}, push);
    run(search, f.counts.searchGroupsX, order, {places.data(), spans.data(), f.projected.data(), pixels.data()}, push);
    return pixels;
}

}  // namespace

std::vector<uint32_t> fillTiles(MslFrame& f, std::span<const Cameraf> views, int order, std::span<const float> farthestSeenM,
                                uint32_t samples) {
    FrameIds ids;
    ids.viewCount = uint32_t(views.size()), ids.widthPx = views[0].widthPx, ids.heightPx = views[0].heightPx, ids.depth = true;
    ids.allSplats = uint32_t(f.projected.size()) / ids.viewCount;
    ids.sceneDepth = !farthestSeenM.empty(), ids.samples = samples;
    const auto tiles = planTiles(ids, {.maxBindingBytes = 128u << 20, .maxGroups = 65535});
    EXPECT_TRUE(tiles);
    const std::vector<uint32_t> pixels = fillBy(*tiles, ids, f, order, farthestSeenM);
    EXPECT_EQ(f.counts.tilesOverflowed, 0u);
    EXPECT_GT(f.counts.tileEntries, f.counts.visible);
    for (const bool ofSpans : {false, true}) {  // with lists that are too small
        TilePlan small = *tiles;
        if (ofSpans)
            small.push.spanCapacity = uint32_t(views.size()) * f.counts.visible;
        else
            small.push.entryCapacity = f.counts.tileEntries - 1;
        MslFrame searched = f;
        EXPECT_TRUE(fillBy(small, ids, searched, order, farthestSeenM) == pixels) << (ofSpans ? "all splats" : "the spans of a row");
        EXPECT_EQ(searched.counts.tilesOverflowed, 1u);
        EXPECT_EQ(searched.counts.tileEntries > 0, !ofSpans);
    }
    return pixels;
}

std::vector<double> rgbOfView(std::span<const uint32_t> pixels, const Cameraf& camera, size_t view) {
    std::vector<double> rgb;
    const size_t count = size_t(camera.widthPx) * camera.heightPx;
    for (const uint32_t pixel : pixels.subspan(view * count, count))
        for (int c = 0; c < 3; ++c) rgb.push_back((pixel >> 8 * c & 255) / 255.0);
    return rgb;
}

}  // namespace dpl
