// SPDX-License-Identifier: Apache-2.0
// The kernels of a training step, in order.
#include "reconstruction/training/gpu/gpu_buffers.h"
#include "sdk/render/passes/scan.h"

namespace dpl {
namespace {

static_assert(offsetof(gpu::FrameCounts, tileEntries) == 4 * gpu::kTrainEntriesWord);

constexpr uint32_t kDepthRounds = 4, kTileRounds = 2;  // digits of a float, and of the number of a tile

/** Pairs to sort, and how many of them: `counts` says it on the device; the host knows it where `groups` is not 0. */
struct PairLists {
    BufferId counts, pairs, swap;
    uint32_t groups = 0;
};

/** Sorts by `rounds` digits from the lowest on; stable, so the order before decides ties. The result lies in `pairs`: rounds is even. */
void addSort(FramePlan& plan, const char* label, const TableIds& digits, const PairLists& lists, uint32_t rounds) {
    BufferId from = lists.pairs, to = lists.swap;
    for (uint32_t round = 0; round < rounds; ++round) {
        const gpu::SortPush push{round * gpu::kSortDigitBits};
        const auto over = [&](auto&& step) {
            if (lists.groups)
                step.groups(lists.groups);
            else
                step.groupsFrom(lists.counts, offsetof(gpu::FrameCounts, runGroupsX));
        };
        over(plan.compute(label, "sort.count").reads(lists.counts, from).writes(digits.cells).push(push));
        addScan(plan, label, lists.counts, digits, {}, gpu::kSortDigits);
        over(plan.compute(label, "sort.scatter").reads(lists.counts, from, digits.places).writes(to).push(push));
        std::swap(from, to);
    }
}

}  // namespace

Status GpuState::record(const GpuStateSizes& sizes) {
    FramePlan activatePlan(backend_);
    activatePlan.compute("activate", "activate")
        .uniform(frame)
        .updates(splats)
        .writes(sh)
        .updates(rows.device)
        .reads(constants)
        .threads(sizes.splats);
    DPL_TRY(activate, activatePlan.finish());
    FramePlan readPlan(backend_);
    for (const ReadBuffer& b : {rows, firstMoments, secondMoments, steps, densitySums, seen}) readPlan.copy("read", b.device, b.host);
    DPL_TRY(readBack, readPlan.finish());
    return {};
}

Status GpuPicture::record(const GpuStateSizes& size, const GpuState& state) {
    const uint32_t n = size.splats, scanRows = (n + gpu::kTrainScanCells - 1) / gpu::kTrainScanCells, pixels = uint32_t(sizes.pixels),
                   tiles = uint32_t(sizes.tiles);
    FramePlan plan(backend_);
    plan.copy("upload", posed.host, posed.device);

    plan.compute("frames", "frames").uniform(frame).reads(state.rests, state.nows, posed.device).writes(triangles).threads(size.triangles);
    plan.compute("project", "project")
        .uniform(frame)
        .reads(state.splats, state.sh, triangles)
        .writes(screen, records, depthPairs)
        .threads(n);
    addSort(plan, "sort by depth", digits, {depthCounts, depthPairs, depthSwap, (n + gpu::kRun - 1) / gpu::kRun}, kDepthRounds);
    plan.compute("count", "count").uniform(frame).reads(depthPairs, screen).writes(cells.cells).threads(scanRows * gpu::kTrainScanCells);
    addScan(plan, "scan", depthCounts, cells, {gpu::kTrainScanCells, 0, 0}, scanRows);
    plan.fill("clear", counts.device, 0);
    plan.compute("args", "args").uniform(frame).reads(cells.sums).updates(counts.device).groups(1);
    plan.compute("entries", "entries")
        .uniform(frame)
        .reads(depthPairs, screen, cells.places)
        .writes(entryPairs, owners, firstEntries)
        .threads(n);
    addSort(plan, "sort by tile", digits, {counts.device, entryPairs, entrySwap}, kTileRounds);
    plan.fill("clear", offsets, 0);
    plan.compute("ranges", "ranges")
        .uniform(frame)
        .reads(counts.device, entryPairs, owners)
        .writes(offsets, entries)
        .groupsFrom(counts.device, offsetof(gpu::FrameCounts, runGroupsX));
    plan.compute("blend", "blend").uniform(frame).reads(offsets, entries, screen).writes(image, cloths, stops).groups(tiles);

    plan.compute("loss", "loss").uniform(frame).reads(image, cloths, target).writes(planes, gradients, sums.device).threads(pixels);
    plan.compute("ssim", "ssim.rows").uniform(frame).reads(planes).writes(blurred).threads(3 * pixels);
    plan.compute("ssim", "ssim.map").uniform(frame).reads(blurred).writes(maps, sums.device).threads(pixels);
    plan.compute("ssim", "ssim.back").uniform(frame).reads(maps).writes(blurred).threads(9 * pixels);
    plan.compute("ssim", "pixel.gradient").uniform(frame).reads(planes, blurred, image, cloths, target).updates(gradients).threads(pixels);

    plan.compute("pixels", "pixels").uniform(frame).reads(offsets, entries, screen, gradients, stops).writes(entrySums).groups(tiles);
    plan.compute("splats", "splats")
        .uniform(frame)
        .reads(state.splats, state.sh, triangles, screen, records, firstEntries, entrySums, state.constants, counts.device)
        .writes(rowGradients.device, shown.device, parts)
        .threads(n);
    plan.compute("triangles", "triangles")
        .uniform(frame)
        .reads(state.starts, shown.device, parts, triangles, state.rests, state.nows)
        .writes(corners)
        .threads(size.triangles);
    plan.compute("vertices", "vertices")
        .uniform(frame)
        .reads(state.incidence, state.cornersOf, corners)
        .writes(vertices.device)
        .threads(size.vertices);
    for (const ReadBuffer& b : {counts, sums, vertices}) plan.copy("read", b.device, b.host);
    DPL_TRY(step, plan.finish());

    FramePlan updatePlan(backend_);
    updatePlan.compute("adam", "adam")
        .uniform(frame)
        .updates(state.splats)
        .writes(state.sh)
        .updates(state.rows.device)
        .reads(rowGradients.device, shown.device)
        .updates(state.firstMoments.device, state.secondMoments.device, state.steps.device, state.densitySums.device, state.seen.device)
        .reads(state.constants, rates, state.corrections)
        .threads(n);
    DPL_TRY(update, updatePlan.finish());

    FramePlan gradientsPlan(backend_);
    for (const ReadBuffer& b : {rowGradients, shown}) gradientsPlan.copy("read gradients", b.device, b.host);
    DPL_TRY(readGradients, gradientsPlan.finish());
    return {};
}

}  // namespace dpl
