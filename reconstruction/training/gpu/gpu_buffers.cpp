// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/gpu_buffers.h"

#include <vector>

#include "sdk/render/passes/scan.h"
#include "sdk/splat/forward_record.h"

namespace dpl {
namespace {

Status add(BufferMaker& maker, ReadBuffer& buffer, const char* label, uint64_t bytes) {
    DPL_RETURN_IF_ERROR(maker.make(buffer.device, label, bytes));
    return maker.make(buffer.host, label, bytes, BufferMemory::Readback);
}

Status add(BufferMaker& maker, UploadedBuffer& buffer, const char* label, uint64_t bytes) {
    DPL_RETURN_IF_ERROR(maker.make(buffer.device, label, bytes));
    return maker.make(buffer.host, label, bytes, BufferMemory::Upload);
}

}  // namespace

Status BufferMaker::make(BufferId& buffer, const char* label, uint64_t bytes, BufferMemory memory) {
    if (memory == BufferMemory::Device) deviceBytes_ += bytes;
    largestBytes_ = std::max(largestBytes_, bytes);
    if (!owner_) return {};
    DPL_TRY(buffer, owner_->create(memory == BufferMemory::Device ? label : std::string(label) + ", of the host", bytes, memory));
    return {};
}

GpuState::~GpuState() {
    for (const FrameId recorded : {activate, readBack})
        if (recorded) backend_.destroyFrame(recorded);
}

Status GpuState::make(const GpuStateSizes& s) {
    BufferMaker maker(&owned_);
    return makeBuffers(s, maker);
}

Status GpuState::makeBuffers(const GpuStateSizes& s, BufferMaker& maker) {
    const uint64_t n = s.splats, rowBytes = n * s.rowFloats * 4;
    DPL_RETURN_IF_ERROR(maker.make(frame, "frame of an upload", sizeof(gpu::TrainFrame), BufferMemory::Upload));
    DPL_RETURN_IF_ERROR(maker.make(splats, "splats", n * sizeof(gpu::TrainSplat)));
    DPL_RETURN_IF_ERROR(maker.make(sh, "spherical harmonics", n * s.shFloats * 4));
    DPL_RETURN_IF_ERROR(maker.make(constants, "constants of triangles", s.triangles * sizeof(gpu::TrainTriangleConstants)));
    DPL_RETURN_IF_ERROR(maker.make(rests, "triangles at rest", s.triangles * sizeof(gpu::TrainRestTriangle)));
    DPL_RETURN_IF_ERROR(maker.make(nows, "triangles at rest, moved", s.triangles * sizeof(gpu::TrainRestInverse)));
    DPL_RETURN_IF_ERROR(maker.make(starts, "first splats", (uint64_t(s.triangles) + 1) * 4));
    DPL_RETURN_IF_ERROR(maker.make(incidence, "first corners", (uint64_t(s.vertices) + 1) * 4));
    DPL_RETURN_IF_ERROR(maker.make(cornersOf, "corners of vertices", uint64_t(s.triangles) * 3 * 4));
    DPL_RETURN_IF_ERROR(maker.make(corrections, "corrections of moments", (uint64_t(gpu::kTrainLastCorrection) + 1) * 8));
    DPL_RETURN_IF_ERROR(add(maker, rows, "rows", rowBytes));
    DPL_RETURN_IF_ERROR(add(maker, firstMoments, "first moments", rowBytes));
    DPL_RETURN_IF_ERROR(add(maker, secondMoments, "second moments", rowBytes));
    DPL_RETURN_IF_ERROR(add(maker, steps, "steps of splats", n * 4));
    DPL_RETURN_IF_ERROR(add(maker, densitySums, "sums for density control", n * 4));
    DPL_RETURN_IF_ERROR(add(maker, seen, "pictures that showed a splat", n * 4));
    return {};
}

GpuPicture::~GpuPicture() {
    for (const FrameId frame : {step, update, readGradients})
        if (frame) backend_.destroyFrame(frame);
}

Status GpuPicture::make(const GpuStateSizes& state, const GpuState& buffers, const GpuPictureSizes& wanted) {
    BufferMaker maker(&owned_);
    sizes = wanted;
    DPL_RETURN_IF_ERROR(makeBuffers(state, wanted, maker));
    // GpuTargets fills it before each step; a step that reads what nobody has written is not recorded.
    const std::vector<std::byte> blank(wanted.pixels * gpu::kTrainPictureWords * 4);
    DPL_RETURN_IF_ERROR(backend_.write(target, 0, blank));
    return record(state, buffers);
}

Status GpuPicture::makeBuffers(const GpuStateSizes& state, const GpuPictureSizes& most, BufferMaker& maker) {
    const uint64_t n = state.splats, triangleCount = state.triangles, pixels = most.pixels, entryCount = most.entries;
    DPL_RETURN_IF_ERROR(maker.make(frame, "frame", sizeof(gpu::TrainFrame), BufferMemory::Upload));
    DPL_RETURN_IF_ERROR(maker.make(depthCounts, "counts of the depth sort", sizeof(gpu::FrameCounts), BufferMemory::Upload));
    DPL_RETURN_IF_ERROR(maker.make(rates, "learning rates", state.rowFloats * 4, BufferMemory::Upload));
    DPL_RETURN_IF_ERROR(add(maker, posed, "posed vertices", uint64_t(state.vertices) * 16));
    DPL_RETURN_IF_ERROR(maker.make(triangles, "triangles", triangleCount * sizeof(gpu::TrainTriangle)));
    DPL_RETURN_IF_ERROR(maker.make(target, "target", pixels * gpu::kTrainPictureWords * 4));

    DPL_RETURN_IF_ERROR(maker.make(screen, "projected splats", n * sizeof(gpu::TrainScreen)));
    DPL_RETURN_IF_ERROR(maker.make(records, "forward records", n * sizeof(ForwardRecord<float>)));
    DPL_RETURN_IF_ERROR(maker.make(firstEntries, "first entries", n * 4));
    DPL_RETURN_IF_ERROR(maker.make(owners, "splats of entries", entryCount * 4));
    DPL_RETURN_IF_ERROR(maker.make(entrySums, "sums of entries", entryCount * sizeof(gpu::TrainEntrySums)));
    DPL_RETURN_IF_ERROR(maker.make(parts, "triangle gradients of splats", n * gpu::kTrainTriangleFours * 16));
    DPL_RETURN_IF_ERROR(maker.make(corners, "gradients of corners", triangleCount * 3 * 16));
    DPL_RETURN_IF_ERROR(maker.make(image, "picture", pixels * 16));
    DPL_RETURN_IF_ERROR(maker.make(cloths, "cloth of the picture", pixels * 4));
    DPL_RETURN_IF_ERROR(maker.make(stops, "stops", pixels * 4));
    DPL_RETURN_IF_ERROR(maker.make(planes, "drawn and wanted", pixels * 6 * 4));
    DPL_RETURN_IF_ERROR(maker.make(blurred, "blurred products", pixels * 15 * 4));
    DPL_RETURN_IF_ERROR(maker.make(maps, "derivatives of the similarity", pixels * 9 * 4));
    DPL_RETURN_IF_ERROR(maker.make(gradients, "gradients of pixels", pixels * 32));
    DPL_RETURN_IF_ERROR(maker.make(depthPairs, "splats by depth", n * sizeof(gpu::SortPair)));
    DPL_RETURN_IF_ERROR(maker.make(depthSwap, "splats by depth, swapped", n * sizeof(gpu::SortPair)));
    DPL_RETURN_IF_ERROR(maker.make(entryPairs, "entries by tile", entryCount * sizeof(gpu::SortPair)));
    DPL_RETURN_IF_ERROR(maker.make(entrySwap, "entries by tile, swapped", entryCount * sizeof(gpu::SortPair)));
    DPL_RETURN_IF_ERROR(maker.make(offsets, "first entries of tiles", (most.tiles + 1) * 4));
    DPL_RETURN_IF_ERROR(maker.make(entries, "entries", entryCount * 8));

    const uint64_t digitCells = gpu::kSortDigits * ((std::max(n, entryCount) + gpu::kRun - 1) / gpu::kRun),
                   scanRows = (n + gpu::kTrainScanCells - 1) / gpu::kTrainScanCells;
    DPL_RETURN_IF_ERROR(maker.make(digits.cells, "digits", digitCells * 4));
    DPL_RETURN_IF_ERROR(maker.make(digits.places, "places of digits", digitCells * 4));
    DPL_RETURN_IF_ERROR(maker.make(digits.sums, "sums of digits", scanSumWords(gpu::kSortDigits) * 4));
    DPL_RETURN_IF_ERROR(maker.make(cells.cells, "entries of splats", scanRows * gpu::kTrainScanCells * 4));
    DPL_RETURN_IF_ERROR(maker.make(cells.places, "places of entries", scanRows * gpu::kTrainScanCells * 4));
    DPL_RETURN_IF_ERROR(maker.make(cells.sums, "sums of entries of splats", scanSumWords(scanRows) * 4));

    DPL_RETURN_IF_ERROR(add(maker, counts, "counts", sizeof(gpu::FrameCounts)));
    DPL_RETURN_IF_ERROR(add(maker, sums, "loss", (pixels + 255) / 256 * gpu::kTrainSums * 4));
    DPL_RETURN_IF_ERROR(add(maker, rowGradients, "row gradients", n * state.rowFloats * 4));
    DPL_RETURN_IF_ERROR(add(maker, shown, "screen gradients", n * 4));
    return add(maker, vertices, "vertex gradients", uint64_t(state.vertices) * 16);
}

}  // namespace dpl
