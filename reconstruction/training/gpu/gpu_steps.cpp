// SPDX-License-Identifier: Apache-2.0
// The kernels of a training step, in order.
#include "reconstruction/training/gpu/gpu_buffers.h"
#include "sdk/render/passes/scan.h"

namespace dpl {
namespace {

constexpr uint32_t kDepthRounds = 4, kTileRounds = 2;  // digits of a float, and of the number of a tile

/** Sorts by `rounds` digits from the lowest on; stable, so the order before decides ties. The result lies in `from`: rounds is even. */
void addSort(FramePlan& plan, const char* label, BufferId counts, const TableIds& digits, BufferId from, BufferId to, uint32_t rounds,
             uint32_t groups) {
    for (uint32_t round = 0; round < rounds; ++round) {
        const gpu::SortPush push{round * gpu::kSortDigitBits};
        const auto over = [&](auto&& step) {
            if (groups)
                step.groups(groups);
            else
                step.groupsFrom(counts, offsetof(gpu::FrameCounts, runGroupsX));
        };
        over(plan.compute(label, "sort.count").reads(counts, from).writes(digits.cells).push(push));
        addScan(plan, label, counts, digits, {}, gpu::kSortDigits);
        over(plan.compute(label, "sort.scatter").reads(counts, from, digits.places).writes(to).push(push));
        std::swap(from, to);
    }
}

}  // namespace

Status GpuBuffers::record() {
    FramePlan plan(backend_);
    for (const UploadedBuffer& b : {splats, sh, triangles, rests, starts, floors, incidence, cornersOf, target})
        plan.copy("upload", b.host, b.device);
    const uint32_t n = sizes.splats, scanRows = (n + gpu::kTrainScanCells - 1) / gpu::kTrainScanCells, pixels = uint32_t(sizes.pixels);

    plan.compute("project", "project")
        .uniform(frame)
        .reads(splats.device, sh.device, triangles.device)
        .writes(screen, records, depthPairs)
        .threads(n);
    addSort(plan, "sort by depth", depthCounts, digits, depthPairs, depthSwap, kDepthRounds, (n + gpu::kRun - 1) / gpu::kRun);
    plan.compute("count", "count").uniform(frame).reads(depthPairs, screen).writes(cells.cells).threads(scanRows * gpu::kTrainScanCells);
    addScan(plan, "scan", depthCounts, cells, {gpu::kTrainScanCells, 0, 0}, scanRows);
    plan.fill("clear", counts.device, 0);
    plan.compute("args", "args").uniform(frame).reads(cells.sums).updates(counts.device).groups(1);
    plan.compute("entries", "entries")
        .uniform(frame)
        .reads(depthPairs, screen, cells.places)
        .writes(entryPairs, owners, firsts)
        .threads(n);
    addSort(plan, "sort by tile", counts.device, digits, entryPairs, entrySwap, kTileRounds, 0);
    plan.fill("clear", offsets, 0);
    plan.compute("ranges", "ranges")
        .uniform(frame)
        .reads(counts.device, entryPairs, owners)
        .writes(offsets, entries)
        .groupsFrom(counts.device, offsetof(gpu::FrameCounts, runGroupsX));
    plan.compute("blend", "blend")
        .uniform(frame)
        .reads(offsets, entries, screen)
        .writes(image, cloths, stops)
        .groups(uint32_t(sizes.tiles));

    plan.compute("loss", "loss")
        .uniform(frame)
        .reads(image, cloths, target.device)
        .writes(planes, gradients, sums.device)
        .threads(pixels);
    plan.compute("ssim", "ssim.rows").uniform(frame).reads(planes).writes(blurred).threads(3 * pixels);
    plan.compute("ssim", "ssim.map").uniform(frame).reads(blurred).writes(maps, sums.device).threads(pixels);
    plan.compute("ssim", "ssim.back").uniform(frame).reads(maps).writes(blurred).threads(9 * pixels);
    plan.compute("ssim", "pixel.gradient")
        .uniform(frame)
        .reads(planes, blurred, image, cloths, target.device)
        .updates(gradients)
        .threads(pixels);

    plan.compute("pixels", "pixels")
        .uniform(frame)
        .reads(offsets, entries, screen, gradients, stops)
        .writes(entrySums)
        .groups(uint32_t(sizes.tiles));
    plan.compute("splats", "splats")
        .uniform(frame)
        .reads(splats.device, sh.device, triangles.device, screen, records, firsts, entrySums, floors.device)
        .writes(rows.device, shown.device, parts)
        .threads(n);
    plan.compute("triangles", "triangles")
        .uniform(frame)
        .reads(starts.device, shown.device, parts, triangles.device, rests.device)
        .writes(corners)
        .threads(sizes.triangles);
    plan.compute("vertices", "vertices")
        .uniform(frame)
        .reads(incidence.device, cornersOf.device, corners)
        .writes(vertices.device)
        .threads(sizes.vertices);
    for (const ReadBuffer& b : {counts, sums, rows, shown, vertices}) plan.copy("read", b.device, b.host);
    DPL_TRY(recorded, plan.finish());
    return {};
}

}  // namespace dpl
