// SPDX-License-Identifier: Apache-2.0
// What frames have left: pixels, and what they drew and cost.
#include "sdk/render/gpu_renderer.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "sdk/math/half.h"

namespace dpl {

GpuRenderer::Row* GpuRenderer::frameRow(const LoadedAvatar& avatar) {
    const auto row = rows_.find(avatar.lastRow);
    return avatar.lastRow == 0 || row == rows_.end() ? nullptr : &row->second;
}

Result<std::span<const PixelView>> GpuRenderer::read(RenderAvatarId id) {
    const auto it = avatars_.find(id);
    if (it == avatars_.end()) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", id);
    Row* row = frameRow(it->second);
    if (!row) return fail(Code::InvalidArgument, "nothing was drawn of avatar {}", id);
    size_t views = 0;
    for (const uint64_t number : row->drawn) {
        if (number == 0) continue;
        const auto drawn = std::find_if(row->frames.begin(), row->frames.end(), [&](const ShapedFrame& f) { return f.lastUse == number; });
        if (drawn == row->frames.end()) return fail(Code::Internal, "frame {} of avatar {} is gone", number, id);
        ShapedFrame& frame = *drawn;
        const Slot& slot = *std::find_if(std::begin(frame.slots), std::end(frame.slots), [&](const Slot& s) { return s.number == number; });
        DPL_CHECK_OK(backend_->wait(slot.draw));
        frame.readTiles = frame.ids.tilePixels && countsOf(slot).tilesOverflowed == 0;
        FrameId& readback = frame.readback[frame.readTiles];
        if (!readback) {
            DPL_CHECK_OK(buildReadback(frame, frame.readTiles));
        }
        DPL_CHECK_OK(backend_->run(readback));
        frame.lastRead = frame.lastUse;
        takePixels(frame, views);
        views += frame.shape.views;
    }
    if (views == 0) return fail(Code::InvalidArgument, "nothing was drawn of avatar {}", id);
    return std::span<const PixelView>(pixels_, views);
}

gpu::FrameCounts GpuRenderer::countsOf(const Slot& slot) {
    gpu::FrameCounts counts;
    std::memcpy(&counts, backend_->mapped(slot.finalCounts).data(), sizeof(counts));
    return counts;
}

bool GpuRenderer::idle(RenderAvatarId id) {
    for (const auto& [number, row] : rows_)
        for (const ShapedFrame& frame : row.frames)
            for (const Slot& slot : frame.slots)
                if (row.holds(id) && !backend_->finished(slot.draw)) return false;
    return true;
}

Result<FrameStats> GpuRenderer::stats(RenderAvatarId id) {
    const auto it = avatars_.find(id);
    if (it == avatars_.end()) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", id);
    FrameStats stats;
    stats.residentBytes = backend_->residentBytes();
    stats.waits = waits_;
    stats.avatarBytes = it->second.avatarBytes, stats.splatBytes = it->second.splatBytes;
    stats.detailShare = it->second.detailShare;
    const Row* row = frameRow(it->second);
    if (!row) return stats;
    stats.splatsAllowed = row->splatsAllowed;
    const auto slotOf = [&](auto isIt) -> std::pair<const ShapedFrame*, const Slot*> {
        std::pair<const ShapedFrame*, const Slot*> found{};
        for (const ShapedFrame& frame : row->frames)
            for (const Slot& slot : frame.slots)
                if (slot.number > (found.second ? found.second->number : 0) && backend_->finished(slot.draw) && isIt(frame, slot))
                    found = {&frame, &slot};
        return found;
    };
    const auto add = [&](const ShapedFrame& frame, const Slot& slot) {
        const gpu::FrameCounts counts = countsOf(slot);
        const auto raise = [](uint32_t& value, uint32_t other) { value = std::max(value, other); };
        stats.views += frame.shape.views;
        stats.chunks = frame.ids.filledGroups;
        stats.components = frame.ids.componentCount;
        raise(stats.componentsInView, slot.componentsInView);
        raise(stats.trianglesInView, counts.trianglesInView), raise(stats.trianglesFacing, counts.trianglesFacing),
            raise(stats.chunksProjected, counts.chunksProjected);
        raise(stats.splatsInView, counts.splatsInView), raise(stats.splatsFacing, counts.splatsFacing),
            raise(stats.splatsDrawn, counts.visible);
        // From survivors and layout: the GPU counts no bytes. Of several avatars the widest SH entry counts for all.
        uint64_t shBytes = 0;
        for (const SubjectIds& subject : row->subjects) {
            stats.bytesDecided += uint64_t(subject.codes.firstPlace - subject.codes.firstParent) * 4;
            shBytes = std::max<uint64_t>(shBytes, (subject.codes.firstShIndex ? 2 : 0) + subject.codes.shWords * 4);
        }
        if (counts.splatsFacing > 0) {
            // Splats that level of detail leaves out are not read.
            const double kept = row->ids.splatCount > 0 ? double(row->splatsAllowed) / row->ids.splatCount : 1;
            stats.bytesDecided += uint64_t(double(counts.chunksProjected) * gpu::kSplatGroup * 5 * kept);
            stats.bytesDecoded += uint64_t(counts.splatsFacing) * 4 + uint64_t(counts.visible) * (4 + shBytes);
        }
        stats.tileEntries += counts.tileEntries;
        stats.tilesOverflowed |= counts.tilesOverflowed != 0;
        for (PassTime& pass : backend_->passTimes(slot.draw)) stats.passes.push_back(std::move(pass));
        if (frame.lastRead == slot.number)
            for (PassTime& pass : backend_->passTimes(frame.readback[frame.readTiles])) stats.passes.push_back(std::move(pass));
    };
    const auto [frame, slot] = slotOf([](const ShapedFrame&, const Slot&) { return true; });
    if (!frame) return stats;
    if (frame->shape.eye == 1) {  // the other eye of the canted pair ran just before
        const auto [first, firstSlot] =
            slotOf([number = slot->number](const ShapedFrame& f, const Slot& s) { return f.shape.eye == 0 && s.number + 1 == number; });
        if (first) add(*first, *firstSlot);
    }
    add(*frame, *slot);
    return stats;
}

void GpuRenderer::takePixels(const ShapedFrame& f, size_t firstView) {
    const size_t pixels = size_t(f.shape.widthPx) * f.shape.heightPx;
    const std::byte* colour = backend_->mapped(f.ids.colourPixels).data();
    const std::byte* depth = f.shape.depth ? backend_->mapped(f.ids.depthPixels).data() : nullptr;
    const bool half = backend_->info().halfDepth;
    for (size_t v = 0; v < f.shape.views; ++v) {
        std::vector<float>& depthM = depthM_[firstView + v];
        depthM.resize(depth ? pixels : 0);
        for (size_t i = 0; i < depthM.size(); ++i) {
            float sums[2];  // Σ α T z, Σ α T
            if (half) {
                uint16_t raw[2];
                std::memcpy(raw, depth + (v * pixels + i) * 4, 4);
                sums[0] = floatFromHalf(raw[0]), sums[1] = floatFromHalf(raw[1]);
            } else {
                std::memcpy(sums, depth + (v * pixels + i) * 8, 8);
            }
            depthM[i] = sums[1] > 0 ? sums[0] / sums[1] : 0.0f;
        }
        std::vector<float>& meshDepthM = meshDepthM_[firstView + v];
        meshDepthM.resize(f.shape.meshDepth ? pixels : 0);
        if (f.shape.meshDepth) {
            std::memcpy(meshDepthM.data(), backend_->mapped(f.ids.meshDepthPixels).data() + v * pixels * 4, pixels * 4);
            std::replace(meshDepthM.begin(), meshDepthM.end(), INFINITY, 0.0f);
        }
        pixels_[firstView + v] = {
            f.shape.widthPx, f.shape.heightPx, {reinterpret_cast<const uint8_t*>(colour) + v * pixels * 4, pixels * 4}, depthM, meshDepthM};
    }
}

}  // namespace dpl
