// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/baseline/plain_tiles.h"

#include <algorithm>

namespace dpl::plain {
namespace {

// Capacity of the lists: a share per splat for small splats, which touch few tiles each, plus a share per tile for large splats.
constexpr uint64_t kSpansPerSplat = 3, kSpansPerTile = 48, kEntriesPerSplat = 4, kEntriesPerTile = 128;

uint32_t tilesAcross(uint32_t px) {
    return (px + kTilePx - 1) / kTilePx;
}

}  // namespace

Result<TilePlan> planTiles(uint32_t splatCount, uint32_t widthPx, uint32_t heightPx, const DeviceInfo& device) {
    TilePlan plan;
    TilePush& p = plan.push;
    p.columns = tilesAcross(widthPx), p.rows = tilesAcross(heightPx), p.widthPx = widthPx, p.heightPx = heightPx;
    const uint64_t tiles = uint64_t(p.rows) * p.columns, runs = (splatCount + kTileRun - 1) / kTileRun,
                   limit = std::min<uint64_t>(device.maxBindingBytes, UINT32_MAX) / 4;
    p.firstEntrySum = p.rows + 1;
    p.firstRunTable = 2 * (p.rows + 1);
    const uint64_t firstTileTable = p.firstRunTable + p.rows * runs, firstSpan = firstTileTable + tiles * kTileSegments;
    if (firstSpan >= limit / 2 || p.rows > device.maxGroups || uint64_t(splatCount) * p.rows > UINT32_MAX ||
        uint64_t(widthPx) * heightPx > limit)
        return fail(Code::Unsupported, "{} x {} px, {} splats: the lists of plain tiles do not fit {}", widthPx, heightPx, splatCount,
                    device.name);
    p.firstTileTable = uint32_t(firstTileTable);
    p.firstSpan = uint32_t(firstSpan + firstSpan % 2);
    // The counts of the GPU are 32 bits: spans that fit cannot have more entries than that.
    p.spanCapacity = uint32_t(
        std::min({kSpansPerSplat * splatCount + kSpansPerTile * tiles, (limit - p.firstSpan) / 2, UINT32_MAX / uint64_t(p.columns)}));
    p.entryCapacity = uint32_t(std::min(kEntriesPerSplat * splatCount + kEntriesPerTile * tiles, limit));
    p.fillGroups = uint32_t(std::min<uint64_t>((tiles * kTilePx + kTileGroup - 1) / kTileGroup, device.maxGroups));
    plan.listWords = p.firstSpan + 2ull * p.spanCapacity;
    return plan;
}

void addTiles(FramePlan& plan, const TilePlan& tiles, uint32_t splatCount, BufferId pairs, BufferId projected, BufferId counts,
              const TileBuffers& to) {
    const TilePush& push = tiles.push;
    plan.fill("tiles.begin", to.counts, 0);
    plan.compute("tiles.runs", "tiles.runs")
        .reads(pairs, projected, counts)
        .updates(to.lists)
        .push(push)
        .threads((splatCount + kTileRun - 1) / kTileRun);
    const auto sum = [&](uint32_t perRow, uint32_t firstTable, uint32_t firstSum) {
        plan.compute("tiles.scan", "tiles.scan")
            .reads(counts)
            .updates(to.lists)
            .push(TileScanPush{perRow, firstTable, firstSum})
            .groups(push.rows);
        plan.compute("tiles.scan", "tiles.sums").updates(to.lists).push(TileSumPush{firstSum, push.rows}).groups(1);
    };
    sum(0, push.firstRunTable, push.firstSpanSum);
    plan.compute("tiles.args", "tiles.args.spans").reads(to.lists).updates(to.counts).reads(counts).push(push).groups(1);
    plan.compute("tiles.spans", "tiles.spans")
        .reads(pairs, projected, counts)
        .updates(to.lists)
        .push(push)
        .groupsFrom(to.counts, offsetof(TileCounts, spanGroupsX));
    plan.compute("tiles.count", "tiles.count").updates(to.lists).push(push).groupsFrom(to.counts, offsetof(TileCounts, rowGroupsX));
    sum(push.columns * kTileSegments, push.firstTileTable, push.firstEntrySum);
    plan.compute("tiles.args", "tiles.args.entries").reads(to.lists).updates(to.counts).push(push).groups(1);
    plan.compute("tiles.entries", "tiles.entries")
        .updates(to.lists)
        .writes(to.entries)
        .push(push)
        .groupsFrom(to.counts, offsetof(TileCounts, entryGroupsX));
    plan.fill("tiles.clear", to.pixels, 0);
    plan.compute("tiles.fill", "tiles.fill")
        .reads(to.lists, to.entries, projected)
        .writes(to.pixels)
        .push(push)
        .groupsFrom(to.counts, offsetof(TileCounts, fillGroupsX));
}

}  // namespace dpl::plain
