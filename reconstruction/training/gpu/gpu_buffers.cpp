// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/gpu_buffers.h"

#include "sdk/render/passes/scan.h"
#include "sdk/splat/forward_record.h"

namespace dpl {
namespace {

uint64_t rowsOf(uint64_t splats) {
    return (splats + gpu::kTrainScanCells - 1) / gpu::kTrainScanCells;
}

}  // namespace

bool GpuSizes::holds(const GpuSizes& o) const {
    return splats == o.splats && triangles == o.triangles && vertices == o.vertices && shFloats == o.shFloats && rowFloats == o.rowFloats &&
           pixels >= o.pixels && tiles >= o.tiles && entries >= o.entries;
}

GpuBuffers::~GpuBuffers() {
    if (recorded) backend_.destroyFrame(recorded);
}

Status GpuBuffers::upload(UploadedBuffer& buffer, const char* label, uint64_t bytes) {
    DPL_TRY(buffer.host, owned_.create(std::string(label) + ", of the host", bytes, BufferMemory::Upload));
    DPL_TRY(buffer.device, owned_.create(label, bytes));
    return {};
}

Status GpuBuffers::read(ReadBuffer& buffer, const char* label, uint64_t bytes) {
    DPL_TRY(buffer.device, owned_.create(label, bytes));
    DPL_TRY(buffer.host, owned_.create(std::string(label) + ", of the host", bytes, BufferMemory::Readback));
    return {};
}

Status GpuBuffers::make(const GpuSizes& wanted) {
    sizes = wanted;
    DPL_RETURN_IF_ERROR(makeBuffers());
    return record();
}

Status GpuBuffers::makeBuffers() {
    const uint64_t n = sizes.splats, triangleCount = sizes.triangles, pixels = sizes.pixels, entryCount = sizes.entries;
    DPL_TRY(frame, owned_.create("frame", sizeof(gpu::TrainFrame), BufferMemory::Upload));
    DPL_TRY(depthCounts, owned_.create("counts of the depth sort", sizeof(gpu::FrameCounts), BufferMemory::Upload));
    DPL_RETURN_IF_ERROR(upload(splats, "splats", n * sizeof(gpu::TrainSplat)));
    DPL_RETURN_IF_ERROR(upload(sh, "spherical harmonics", n * sizes.shFloats * 4));
    DPL_RETURN_IF_ERROR(upload(triangles, "triangles", triangleCount * sizeof(gpu::TrainTriangle)));
    DPL_RETURN_IF_ERROR(upload(rests, "triangles at rest", triangleCount * sizeof(gpu::TrainRest)));
    DPL_RETURN_IF_ERROR(upload(starts, "first splats", (triangleCount + 1) * 4));
    DPL_RETURN_IF_ERROR(upload(floors, "size floors", triangleCount * 4));
    DPL_RETURN_IF_ERROR(upload(incidence, "first corners", (uint64_t(sizes.vertices) + 1) * 4));
    DPL_RETURN_IF_ERROR(upload(cornersOf, "corners of vertices", triangleCount * 3 * 4));
    DPL_RETURN_IF_ERROR(upload(target, "target", pixels * gpu::kTrainPictureWords * 4));

    DPL_TRY(screen, owned_.create("projected splats", n * sizeof(gpu::TrainScreen)));
    DPL_TRY(records, owned_.create("forward records", n * sizeof(ForwardRecord<float>)));
    DPL_TRY(firsts, owned_.create("first entries", n * 4));
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

    const uint64_t digitCells = gpu::kSortDigits * ((std::max(n, entryCount) + gpu::kRun - 1) / gpu::kRun), rowCount = rowsOf(n);
    DPL_TRY(digits.cells, owned_.create("digits", digitCells * 4));
    DPL_TRY(digits.places, owned_.create("places of digits", digitCells * 4));
    DPL_TRY(digits.sums, owned_.create("sums of digits", scanSumWords(gpu::kSortDigits) * 4));
    DPL_TRY(cells.cells, owned_.create("entries of splats", rowCount * gpu::kTrainScanCells * 4));
    DPL_TRY(cells.places, owned_.create("places of entries", rowCount * gpu::kTrainScanCells * 4));
    DPL_TRY(cells.sums, owned_.create("sums of entries of splats", scanSumWords(rowCount) * 4));

    DPL_RETURN_IF_ERROR(read(counts, "counts", sizeof(gpu::FrameCounts)));
    DPL_RETURN_IF_ERROR(read(sums, "loss", (pixels + 255) / 256 * gpu::kTrainSums * 4));
    DPL_RETURN_IF_ERROR(read(rows, "row gradients", n * sizes.rowFloats * 4));
    DPL_RETURN_IF_ERROR(read(shown, "screen gradients", n * 4));
    return read(vertices, "vertex gradients", uint64_t(sizes.vertices) * 16);
}

}  // namespace dpl
