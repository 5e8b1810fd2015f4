// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/write_on_gpu.h"

#include <algorithm>

namespace dpl::api {
namespace {

static_assert(DPL_SPLAT_POSITION == gpu::kWritePosition && DPL_SPLAT_ROTATION == gpu::kWriteRotation &&
              DPL_SPLAT_SCALE == gpu::kWriteScale && DPL_SPLAT_COVARIANCE == gpu::kWriteCovariance &&
              DPL_SPLAT_OPACITY == gpu::kWriteOpacity && DPL_SPLAT_COLOUR == gpu::kWriteColour && DPL_SPLAT_SH == gpu::kWriteSh &&
              DPL_SPLAT_ROTATION_WXYZ == gpu::kWriteRotationWxyz && DPL_MAX_BUFFER_ELEMENTS == gpu::kWrittenElements);

constexpr uint64_t kBindingStep = 256;  // no device wants a binding to begin at multiples of more

/** The bytes of the program's buffer that all rows lie in, and the elements in words of it. */
struct BoundRows {
    uint64_t offset = 0, bytes = 0;
    std::array<gpu::uvec4, DPL_MAX_BUFFER_ELEMENTS> elements;
};

BoundRows boundRows(const BufferLayout& layout, uint64_t count) {
    BoundRows bound;
    uint64_t first = ~0ull, end = 0;
    for (const BufferRows& rows : layout.all()) first = std::min(first, rows.offset), end = std::max(end, rows.end(count));
    bound.offset = first / kBindingStep * kBindingStep;
    bound.bytes = (end + 3) / 4 * 4 - bound.offset;
    for (uint32_t i = 0; i < layout.count; ++i) {
        const BufferRows& rows = layout.rows[i];
        bound.elements[i] = {rows.property, uint32_t((rows.offset - bound.offset) / 4), uint32_t(rows.stride / 4), rows.half ? 1u : 0u};
    }
    return bound;
}

}  // namespace

Status countSplats(const AppSide& side, const Avatar& avatar, const SplatRequest& request, DplWritten* written) {
    DplWritten out{};
    DPL_TRY(out.count, side.renderer.writtenRows(avatar.renderId, request.budget));
    return writeStruct(written, out, "written");
}

Status writeSplatsOnGpu(const AppSide& side, Avatar& avatar, const SplatRequest& request, const GpuBuffer& buffer,
                        const WriteRecording& recording, DplWritten* written) {
    DPL_TRY(const uint32_t count, side.renderer.writtenRows(avatar.renderId, request.budget));
    DPL_TRY(const BufferLayout layout,
            layoutOf(buffer.elements, buffer.elementCount, buffer.bytes, splatProperties(request.shDegree), count, RowWriter::Gpu));
    DPL_TRY(const uint64_t joined, side.backend.joinSlot(recording.slot));
    DPL_RETURN_IF_ERROR(countSplats(side, avatar, request, written));
    if (count == 0) return {};
    const BoundRows bound = boundRows(layout, count);
    const DeviceInfo& device = side.backend.info();
    if (bound.bytes > device.maxBindingBytes)
        return fail(Code::Unsupported,
                    "the rows lie {} bytes apart at most, {} binds {} at once; use a smaller stride, or a buffer for each", bound.bytes,
                    device.name, device.maxBindingBytes);
    avatar.clock.show(avatar.data->correctives.motion, avatar.pose);
    const SplatWrite write{{avatar.renderId, &avatar.drawnPose(), avatar.placement, avatar.hiddenLayers},
                           request.budget,
                           request.shDegree,
                           request.eye,
                           {bound.elements.data(), layout.count}};
    const auto lend = [&](FrameId frame, BufferId rows) { return recording.lend(frame, rows, bound.offset, bound.bytes); };
    return side.renderer.encodeWrite(write, {recording.slot, joined, recording.commands, lend});
}

}  // namespace dpl::api
