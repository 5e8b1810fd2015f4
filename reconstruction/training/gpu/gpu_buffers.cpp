// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/gpu_buffers.h"

#include "sdk/render/passes/scan.h"
#include "sdk/splat/forward_record.h"

namespace dpl {
namespace {

Status makeRead(DeviceBuffers& owned, ReadBuffer& buffer, const char* label, uint64_t bytes) {
    DPL_TRY(buffer.device, owned.create(label, bytes));
    DPL_TRY(buffer.host, owned.create(std::string(label) + ", of the host", bytes, BufferMemory::Readback));
    return {};
}

}  // namespace

GpuState::~GpuState() {
    for (const FrameId recorded : {activate, readBack})
        if (recorded) backend_.destroyFrame(recorded);
}

Status GpuState::add(ReadBuffer& buffer, const char* label, uint64_t bytes) {
    return makeRead(owned_, buffer, label, bytes);
}

Status GpuState::make(const GpuStateSizes& s) {
    const uint64_t n = s.splats, rowBytes = n * s.rowFloats * 4;
    DPL_TRY(frame, owned_.create("frame of an upload", sizeof(gpu::TrainFrame), BufferMemory::Upload));
    DPL_TRY(splats, owned_.create("splats", n * sizeof(gpu::TrainSplat)));
    DPL_TRY(sh, owned_.create("spherical harmonics", n * s.shFloats * 4));
    DPL_TRY(constants, owned_.create("constants of triangles", s.triangles * sizeof(gpu::TrainTriangleConstants)));
    DPL_TRY(starts, owned_.create("first splats", (uint64_t(s.triangles) + 1) * 4));
    DPL_TRY(incidence, owned_.create("first corners", (uint64_t(s.vertices) + 1) * 4));
    DPL_TRY(cornersOf, owned_.create("corners of vertices", uint64_t(s.triangles) * 3 * 4));
    DPL_TRY(corrections, owned_.create("corrections of moments", (uint64_t(gpu::kTrainLastCorrection) + 1) * 8));
    DPL_RETURN_IF_ERROR(add(rows, "rows", rowBytes));
    DPL_RETURN_IF_ERROR(add(firstMoments, "first moments", rowBytes));
    DPL_RETURN_IF_ERROR(add(secondMoments, "second moments", rowBytes));
    DPL_RETURN_IF_ERROR(add(steps, "steps of splats", n * 4));
    DPL_RETURN_IF_ERROR(add(densitySums, "sums for density control", n * 4));
    DPL_RETURN_IF_ERROR(add(seen, "pictures that showed a splat", n * 4));
    return {};
}

GpuPicture::~GpuPicture() {
    for (const FrameId frame : {step, readGradients})
        if (frame) backend_.destroyFrame(frame);
}

Status GpuPicture::add(UploadedBuffer& buffer, const char* label, uint64_t bytes) {
    DPL_TRY(buffer.host, owned_.create(std::string(label) + ", of the host", bytes, BufferMemory::Upload));
    DPL_TRY(buffer.device, owned_.create(label, bytes));
    return {};
}

Status GpuPicture::add(ReadBuffer& buffer, const char* label, uint64_t bytes) {
    return makeRead(owned_, buffer, label, bytes);
}

Status GpuPicture::make(const GpuStateSizes& state, const GpuState& buffers, const GpuPictureSizes& wanted) {
    sizes = wanted;
    DPL_RETURN_IF_ERROR(makeBuffers(state));
    return record(state, buffers);
}

Status GpuPicture::makeBuffers(const GpuStateSizes& state) {
    const uint64_t n = state.splats, triangleCount = state.triangles, pixels = sizes.pixels, entryCount = sizes.entries;
    DPL_TRY(frame, owned_.create("frame", sizeof(gpu::TrainFrame), BufferMemory::Upload));
    DPL_TRY(depthCounts, owned_.create("counts of the depth sort", sizeof(gpu::FrameCounts), BufferMemory::Upload));
    DPL_TRY(rates, owned_.create("learning rates", state.rowFloats * 4, BufferMemory::Upload));
    DPL_RETURN_IF_ERROR(add(triangles, "triangles", triangleCount * sizeof(gpu::TrainTriangle)));
    DPL_RETURN_IF_ERROR(add(rests, "triangles at rest", triangleCount * sizeof(gpu::TrainRest)));
    DPL_RETURN_IF_ERROR(add(target, "target", pixels * gpu::kTrainPictureWords * 4));

    DPL_TRY(screen, owned_.create("projected splats", n * sizeof(gpu::TrainScreen)));
    DPL_TRY(records, owned_.create("forward records", n * sizeof(ForwardRecord<float>)));
    DPL_TRY(firstEntries, owned_.create("first entries", n * 4));
    DPL_TRY(owners, owned_.create("splats of entries", entryCount * 4));
    DPL_TRY(entrySums, owned_.create("sums of entries", entryCount * sizeof(gpu::TrainEntrySums)));
    DPL_TRY(parts, owned_.create("triangle gradients of splats", n * gpu::kTrainTriangleFours * 16));
    DPL_TRY(corners, owned_.create("gradients of corners", triangleCount * 3 * 16));
    DPL_TRY(image, owned_.create("picture", pixels * 16));
    DPL_TRY(cloths, owned_.create("cloth of the picture", pixels * 4));
    DPL_TRY(stops, owned_.create("stops", pixels * 4));
    DPL_TRY(planes, owned_.create("drawn and wanted", pixels * 6 * 4));
    DPL_TRY(blurred, owned_.create("blurred products", pixels * 15 * 4));
    DPL_TRY(maps, owned_.create("derivatives of the similarity", pixels * 9 * 4));
    DPL_TRY(gradients, owned_.create("gradients of pixels", pixels * 32));
    DPL_TRY(depthPairs, owned_.create("splats by depth", n * sizeof(gpu::SortPair)));
    DPL_TRY(depthSwap, owned_.create("splats by depth, swapped", n * sizeof(gpu::SortPair)));
    DPL_TRY(entryPairs, owned_.create("entries by tile", entryCount * sizeof(gpu::SortPair)));
    DPL_TRY(entrySwap, owned_.create("entries by tile, swapped", entryCount * sizeof(gpu::SortPair)));
    DPL_TRY(offsets, owned_.create("first entries of tiles", (sizes.tiles + 1) * 4));
    DPL_TRY(entries, owned_.create("entries", entryCount * 8));

    const uint64_t digitCells = gpu::kSortDigits * ((std::max(n, entryCount) + gpu::kRun - 1) / gpu::kRun),
                   scanRows = (n + gpu::kTrainScanCells - 1) / gpu::kTrainScanCells;
    DPL_TRY(digits.cells, owned_.create("digits", digitCells * 4));
    DPL_TRY(digits.places, owned_.create("places of digits", digitCells * 4));
    DPL_TRY(digits.sums, owned_.create("sums of digits", scanSumWords(gpu::kSortDigits) * 4));
    DPL_TRY(cells.cells, owned_.create("entries of splats", scanRows * gpu::kTrainScanCells * 4));
    DPL_TRY(cells.places, owned_.create("places of entries", scanRows * gpu::kTrainScanCells * 4));
    DPL_TRY(cells.sums, owned_.create("sums of entries of splats", scanSumWords(scanRows) * 4));

    DPL_RETURN_IF_ERROR(add(counts, "counts", sizeof(gpu::FrameCounts)));
    DPL_RETURN_IF_ERROR(add(sums, "loss", (pixels + 255) / 256 * gpu::kTrainSums * 4));
    DPL_RETURN_IF_ERROR(add(rowGradients, "row gradients", n * state.rowFloats * 4));
    DPL_RETURN_IF_ERROR(add(shown, "screen gradients", n * 4));
    return add(vertices, "vertex gradients", uint64_t(state.vertices) * 16);
}

}  // namespace dpl
