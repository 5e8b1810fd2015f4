// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/tiles.h"

#include <algorithm>

#include "sdk/math/coverage.h"
#include "sdk/render/passes/scan.h"

namespace dpl {
namespace {

// Capacity of the lists. It allows a few tiles for each splat, for small splats, plus a mean depth of splats for each tile, for large
// ones. The latter is counted for each 64 pixels, a tile at one sample, so that smaller tiles take no more memory.
constexpr uint64_t kSpansPerSplat = 3, kSpansPer64Px = 48, kEntriesPerSplat = 4, kEntriesPer64Px = 128;

constexpr uint32_t kTableHead = 3;  // words at the start of `places`: the numbers of splats, of runs and of spans

}  // namespace

std::optional<TilePlan> planTiles(const FrameIds& ids, const DeviceInfo& device) {
    TilePlan plan;
    gpu::TilePush& p = plan.push;
    p.tileShift = ids.samples == 1 ? gpu::kTilePxShift : gpu::kFourTilePxShift;
    p.reachPx = ids.samples == 1 ? 0 : kCoverageReachPx;
    const uint32_t side = 1u << p.tileShift;
    p.viewCount = ids.viewCount, p.columns = (ids.widthPx + side - 1) / side, p.rows = (ids.heightPx + side - 1) / side;
    p.widthPx = ids.widthPx, p.heightPx = ids.heightPx, p.splatCount = ids.allSplats;
    const uint64_t rows = plan.rows(), tiles = rows * p.columns, records = uint64_t(ids.allSplats) * ids.viewCount,
                   pixels = uint64_t(p.widthPx) * p.heightPx * p.viewCount;
    const uint64_t blocks = (tiles * side * side + 63) / 64;
    const uint64_t runs = (ids.allSplats + gpu::kRun - 1) / gpu::kRun;
    p.firstSpanSum = 0;
    p.firstEntrySum = uint32_t(scanSumWords(rows));
    plan.sumWords = 2 * scanSumWords(rows);
    p.firstRunTable = kTableHead;
    const uint64_t firstTileTable = kTableHead + rows * runs;
    plan.tableWords = firstTileTable + tiles * gpu::kTileSegments;
    const uint64_t limit = std::min<uint64_t>(device.maxBindingBytes, UINT32_MAX) / 4;
    if (plan.tableWords > limit || rows * gpu::kTileSegments > device.maxGroups || std::max(p.rows, p.columns) > gpu::kMostTiles ||
        records * p.rows > UINT32_MAX)
        return std::nullopt;
    p.firstTileTable = uint32_t(firstTileTable);
    // Counts on the GPU have 32 bits. The capacity of spans is such that their entries cannot exceed that.
    p.spanCapacity = uint32_t(std::min({kSpansPerSplat * records + kSpansPer64Px * blocks, limit / 2, UINT32_MAX / uint64_t(p.columns)}));
    p.entryCapacity = uint32_t(std::min(kEntriesPerSplat * records + kEntriesPer64Px * blocks, limit));
    p.fillGroups = uint32_t(std::min<uint64_t>((tiles * side + gpu::kTileGroup - 1) / gpu::kTileGroup, device.maxGroups));
    p.halfDepth = device.halfDepth ? 1 : 0;
    if (records > p.spanCapacity) return std::nullopt;  // of a search: a span for each splat and view
    const auto part = [](uint64_t bytes) {
        return std::max<uint64_t>((bytes + 7) / 8 * 8, 16);
    };  // 16 bytes is the smallest buffer (DeviceBuffers), and each part is copied from or to a buffer of its own
    const uint64_t depthOffset = part(pixels * 4);
    plan.spanBytes = p.spanCapacity * 8ull;
    plan.entryBytes = p.entryCapacity * 4ull;
    const uint64_t sceneOffset = depthOffset + (ids.depth ? part(pixels * (device.halfDepth ? 4 : 8)) : 0);
    plan.pixelBytes = sceneOffset + (ids.sceneDepth ? part(pixels * 4) : 0);
    p.firstDepth = uint32_t(depthOffset / 4);
    p.firstScene = uint32_t(sceneOffset / 4);
    if (plan.pixelBytes > device.maxBindingBytes || pixels * 4 > UINT32_MAX) return std::nullopt;
    return plan;
}

TileKernels tileKernelsOf(const FrameIds& ids, uint32_t samples) {
    const std::string of = std::string(ids.depth ? ".depth" : "") + (ids.sceneDepth ? ".scene" : "") + (samples > 1 ? ".four" : "");
    return {(ids.shuffle ? "tiles.fill.shuffle" : "tiles.fill") + of, "tiles.search" + of};
}

void addTiles(FramePlan& plan, const FrameIds& ids, const TilePlan& tiles) {
    const gpu::TilePush& push = tiles.push;
    plan.compute("tiles.runs", ids.ofViews("tiles.runs"))
        .reads(ids.pairs, ids.projected, ids.counts)
        .writes(ids.tiles.cells)
        .push(push)
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, runGroupsX));
    addScan(plan, "tiles.scan", ids.counts, ids.tiles, {0, push.firstRunTable, push.firstSpanSum}, tiles.rows());
    plan.compute("tiles.args", "tiles.args.spans").reads(ids.tiles.sums).updates(ids.counts).writes(ids.tiles.places).push(push).groups(1);
    plan.compute("tiles.spans", ids.ofViews("tiles.spans"))
        .reads(ids.pairs, ids.projected, ids.tiles.places)
        .writes(ids.tileSpans)
        .push(push)
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, runGroupsX));
    plan.compute("tiles.count", "tiles.count")
        .reads(ids.tileSpans, ids.tiles.sums)
        .writes(ids.tiles.cells)
        .push(push)
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, rowGroupsX));
    addScan(plan, "tiles.scan", ids.counts, ids.tiles, {push.columns * gpu::kTileSegments, push.firstTileTable, push.firstEntrySum},
            tiles.rows());
    plan.compute("tiles.args", "tiles.args.entries").reads(ids.tiles.sums).updates(ids.counts).push(push).groups(1);
    plan.compute("tiles.entries", "tiles.entries")
        .reads(ids.tileSpans, ids.tiles.sums)
        .updates(ids.tiles.places)
        .writes(ids.tileEntries)
        .push(push)
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, entryGroupsX));
    plan.fill("tiles.clear", ids.tilePixels, 0);
    // The scene's depth lies behind the pixels in one buffer, because phones promise only four storage buffers a stage.
    if (ids.sceneDepth) plan.copy("tiles.scene", ids.scene, ids.tilePixels, push.firstScene * 4ull);
    const TileKernels kernels = tileKernelsOf(ids, ids.samples);
    const auto addFill = [&](const char* label, const std::string& kernel, BufferId list, uint64_t groups) {
        auto fill = plan.compute(label, kernel);
        fill.reads(ids.tiles.places, list, ids.projected);
        if (ids.sceneDepth)
            fill.updates(ids.tilePixels);
        else
            fill.writes(ids.tilePixels);
        fill.push(push).groupsFrom(ids.counts, groups);
    };
    addFill("tiles.fill", kernels.fill, ids.tileEntries, offsetof(gpu::FrameCounts, fillGroupsX));
    addFill("tiles.search", kernels.search, ids.tileSpans, offsetof(gpu::FrameCounts, searchGroupsX));
}

}  // namespace dpl
