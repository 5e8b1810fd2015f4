#include "sdk/render/passes/tiles.h"

#include <algorithm>

namespace dpl {
namespace {

// What the lists hold, from both ends: small splats touch a few tiles each, and however large splats are, so many deep is a tile on average.
constexpr uint64_t kSpansPerSplat = 3, kSpansPerTile = 48, kEntriesPerSplat = 4, kEntriesPerTile = 128;

uint32_t tilesAcross(uint32_t px) { return (px + gpu::kTilePx - 1) / gpu::kTilePx; }

}  // namespace

std::optional<TilePlan> planTiles(const FrameIds& ids, const DeviceInfo& device) {
    TilePlan plan;
    gpu::TilePush& p = plan.push;
    p.viewCount = ids.viewCount, p.columns = tilesAcross(ids.widthPx), p.rows = tilesAcross(ids.heightPx);
    p.widthPx = ids.widthPx, p.heightPx = ids.heightPx;
    const uint64_t rows = plan.rows(), tiles = rows * p.columns, records = uint64_t(ids.splatCount) * ids.viewCount, pixels = uint64_t(p.widthPx) * p.heightPx * p.viewCount;
    const uint64_t runs = (ids.splatCount + gpu::kRun - 1) / gpu::kRun;
    p.firstSpanSum = 0;
    p.firstEntrySum = uint32_t(rows + 1);
    p.firstRunTable = uint32_t(2 * (rows + 1));
    const uint64_t firstTileTable = p.firstRunTable + rows * runs, firstSpan = firstTileTable + tiles * gpu::kTileSegments;
    const uint64_t limit = std::min<uint64_t>(device.maxBindingBytes, UINT32_MAX) / 4;
    if (firstSpan >= limit / 2 || rows > device.maxGroups || records * p.rows > UINT32_MAX) return std::nullopt;
    p.firstTileTable = uint32_t(firstTileTable);
    p.firstSpan = uint32_t(firstSpan + firstSpan % 2);
    // The counts of the GPU are 32 bits: spans that fit cannot have more entries than that.
    p.spanCapacity = uint32_t(std::min({kSpansPerSplat * records + kSpansPerTile * tiles, (limit - p.firstSpan) / 2, UINT32_MAX / uint64_t(p.columns)}));
    p.entryCapacity = uint32_t(std::min(kEntriesPerSplat * records + kEntriesPerTile * tiles, limit));
    p.fillGroups = uint32_t(std::min<uint64_t>((tiles * gpu::kTilePx + gpu::kTileGroup - 1) / gpu::kTileGroup, device.maxGroups));
    p.halfColour = ids.halfColour ? 1 : 0;
    p.halfDepth = device.halfDepth ? 1 : 0;
    const uint64_t depthOffset = (pixels * (ids.halfColour ? 8 : 4) + 7) / 8 * 8;
    plan.listBytes = (p.firstSpan + 2ull * p.spanCapacity) * 4;
    plan.entryBytes = p.entryCapacity * 4ull;
    const uint64_t sceneOffset = depthOffset + (ids.depth ? pixels * (device.halfDepth ? 4 : 8) : 0);
    plan.pixelBytes = sceneOffset + (ids.sceneDepth ? std::max<uint64_t>(pixels * 4, 16) : 0);  // 16: the smallest buffer
    p.firstDepth = uint32_t(depthOffset / 4);
    p.firstScene = uint32_t(sceneOffset / 4);
    if (plan.pixelBytes > device.maxBindingBytes || pixels * 4 > UINT32_MAX) return std::nullopt;
    return plan;
}

void addTiles(FramePlan& plan, const FrameIds& ids, const TilePlan& tiles) {
    const gpu::TilePush& push = tiles.push;
    plan.compute("tiles.runs", ids.ofViews("tiles.runs")).reads(ids.pairs, ids.projected, ids.counts).updates(ids.tileLists).push(push).groupsFrom(ids.counts, offsetof(gpu::FrameCounts, runGroupsX));
    const auto sum = [&](uint32_t perRow, uint32_t firstTable, uint32_t firstSum) {
        plan.compute("tiles.scan", "scan.rows").reads(ids.counts).updates(ids.tileLists).push(gpu::RowScanPush{perRow, firstTable, firstSum}).groups(tiles.rows());
        plan.compute("tiles.scan", "scan.sums").updates(ids.tileLists).push(gpu::ScanPush{firstSum, tiles.rows()}).groups(1);
    };
    sum(0, push.firstRunTable, push.firstSpanSum);
    plan.compute("tiles.args", "tiles.args.spans").reads(ids.tileLists).updates(ids.counts).push(push).groups(1);
    plan.compute("tiles.spans", ids.ofViews("tiles.spans")).reads(ids.pairs, ids.projected, ids.counts).updates(ids.tileLists).push(push).groupsFrom(ids.counts, offsetof(gpu::FrameCounts, spanGroupsX));
    plan.compute("tiles.count", "tiles.count").updates(ids.tileLists).push(push).groupsFrom(ids.counts, offsetof(gpu::FrameCounts, rowGroupsX));
    sum(push.columns * gpu::kTileSegments, push.firstTileTable, push.firstEntrySum);
    plan.compute("tiles.args", "tiles.args.entries").reads(ids.tileLists).updates(ids.counts).push(push).groups(1);
    plan.compute("tiles.entries", "tiles.entries").updates(ids.tileLists).writes(ids.tileEntries).push(push).groupsFrom(ids.counts, offsetof(gpu::FrameCounts, entryGroupsX));
    plan.fill("tiles.clear", ids.tilePixels, 0);
    if (ids.sceneDepth) plan.copy("tiles.scene", ids.scene, ids.tilePixels, push.firstScene * 4ull);  // a stage has four buffers: the scene lies behind the pixels
    auto fill = plan.compute("tiles.fill", std::string(ids.shuffle ? "tiles.fill.shuffle" : "tiles.fill") + (ids.depth ? ".depth" : "") + (ids.sceneDepth ? ".scene" : ""));
    fill.reads(ids.tileLists, ids.tileEntries, ids.projected);
    if (ids.sceneDepth) fill.updates(ids.tilePixels);
    else fill.writes(ids.tilePixels);
    fill.push(push)
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, fillGroupsX));
    plan.putPixels("tiles.put", ids.target, ids.tilePixels, push.firstDepth * 4ull);
}

}  // namespace dpl
