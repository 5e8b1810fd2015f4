// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/frame_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sdk/math/half.h"
#include "sdk/render/plan.h"

namespace dpl {

Result<std::span<const PixelView>> FrameReader::read(std::span<const SubmittedFrame> frames) {
    size_t views = 0;
    for (const SubmittedFrame& drawn : frames) {
        Readback& readback = readbacks_.try_emplace(drawn.frame->key, backend_).first->second;
        DPL_RETURN_IF_ERROR(copy(*drawn.frame, *drawn.slot, readback));
        takePixels(*drawn.frame, readback, views);
        views += drawn.frame->shape.views;
    }
    return std::span<const PixelView>(pixels_, views);
}

Status FrameReader::copy(const RecordedFrame& frame, const FrameSlot& slot, Readback& readback) {
    DPL_RETURN_IF_ERROR(backend_.wait(slot.recorded));
    if (!readback.copy) {
        DPL_TRY(readback.copy, recordCopy(frame, readback));
    }
    readback.lastNumber = slot.last.number;
    return backend_.run(readback.copy);
}

Result<FrameId> FrameReader::recordCopy(const RecordedFrame& frame, Readback& readback) {
    const FrameIds& ids = frame.ids;
    const uint64_t pixels = uint64_t(ids.widthPx) * ids.heightPx * ids.viewCount;
    const auto bufferOf = [&](BufferId& buffer, const char* label, uint64_t bytes) -> Status {
        if (buffer) return {};  // of an attempt that failed
        DPL_TRY(buffer, readback.buffers.create(label, bytes, BufferMemory::Readback));
        return {};
    };
    FramePlan plan(backend_);
    DPL_RETURN_IF_ERROR(bufferOf(readback.colour, "colour pixels", pixels * 4));
    if (ids.depth) {
        DPL_RETURN_IF_ERROR(bufferOf(readback.depth, "depth pixels", pixels * (backend_.info().halfDepth ? 4 : 8)));
    }
    if (ids.tilePixels) {
        plan.copy("readback", ids.tilePixels, readback.colour);
        if (ids.depth) plan.copy("readback", ids.tilePixels, readback.depth, frame.tileDepthOffset);
    } else {
        plan.readback("readback", ids.target, readback.colour, readback.depth);
    }
    if (ids.meshDepth) {
        DPL_RETURN_IF_ERROR(bufferOf(readback.meshDepth, "mesh depth pixels", pixels * 4));
        plan.copy("mesh readback", ids.meshDepth, readback.meshDepth);
    }
    return plan.finish();
}

void FrameReader::takePixels(const RecordedFrame& frame, const Readback& readback, size_t firstView) {
    const FrameShape& shape = frame.shape;
    const size_t pixels = size_t(shape.widthPx) * shape.heightPx;
    const std::span<std::byte> mapped = backend_.mapped(readback.colour);
    if (!frame.ids.tilePixels) opacityFromTransmittance(mapped);
    const auto* colour = reinterpret_cast<const uint8_t*>(mapped.data());
    for (size_t v = 0; v < shape.views; ++v) {
        std::vector<float>& depthM = depthM_[firstView + v];
        depthM.resize(shape.depth ? pixels : 0);
        if (shape.depth) takeDepth(backend_.mapped(readback.depth), v * pixels, depthM);
        std::vector<float>& meshDepthM = meshDepthM_[firstView + v];
        meshDepthM.resize(shape.meshDepth ? pixels : 0);
        if (shape.meshDepth) {
            std::memcpy(meshDepthM.data(), backend_.mapped(readback.meshDepth).data() + v * pixels * 4, pixels * 4);
            std::replace(meshDepthM.begin(), meshDepthM.end(), INFINITY, 0.0f);
        }
        pixels_[firstView + v] = {shape.widthPx, shape.heightPx, {colour + v * pixels * 4, pixels * 4}, depthM, meshDepthM};
    }
}

/** Depth from the two sums of a pixel, Σ α T z and Σ α T. */
void FrameReader::takeDepth(std::span<const std::byte> sums, size_t firstPixel, std::vector<float>& depthM) const {
    const bool half = backend_.info().halfDepth;
    for (size_t i = 0; i < depthM.size(); ++i) {
        float pixel[2];
        if (half) {
            uint16_t raw[2];
            std::memcpy(raw, sums.data() + (firstPixel + i) * 4, 4);
            pixel[0] = floatFromHalf(raw[0]), pixel[1] = floatFromHalf(raw[1]);
        } else {
            std::memcpy(pixel, sums.data() + (firstPixel + i) * 8, 8);
        }
        depthM[i] = pixel[1] > 0 ? pixel[0] / pixel[1] : 0.0f;
    }
}

gpu::FrameCounts FrameReader::countsOf(const FrameSlot& slot) const {
    gpu::FrameCounts counts;
    std::memcpy(&counts, backend_.mapped(slot.finalCounts).data(), sizeof(counts));
    return counts;
}

void FrameReader::keepFinished(FrameSlot& slot) const {
    slot.before = finishedOf(slot);
    if (slot.before.number > 0) slot.countsBefore = countsOf(slot);
}

/** The last frame of the slot that is known to have finished; number 0: none. */
FrameFacts FrameReader::finishedOf(const FrameSlot& slot) const {
    return backend_.finished(slot.recorded) ? slot.last : slot.before;
}

FrameReader::Finished FrameReader::lastFinished(const SceneSet& set) const {
    Finished last;
    for (const RecordedFrame& frame : set.frames)
        for (const FrameSlot& slot : frame.slots)
            if (const FrameFacts facts = finishedOf(slot); facts.endsDraw && facts.number > last.facts.number)
                last = {&frame, &slot, facts};
    return last;
}

/** The frame of the first eye of a canted pair. It was drawn just before the second. */
FrameReader::Finished FrameReader::firstEyeOf(const SceneSet& set, const FrameFacts& second) const {
    for (const RecordedFrame& frame : set.frames)
        for (const FrameSlot& slot : frame.slots)
            if (const FrameFacts facts = finishedOf(slot); frame.shape.eye == 0 && facts.number > 0 && facts.number + 1 == second.number)
                return {&frame, &slot, facts};
    return {};
}

FrameTiming FrameReader::timing(const SceneSet& set) const {
    FrameTiming timing;
    const Finished last = lastFinished(set);
    if (!last) return timing;
    timing.frame = last.facts.number;
    timing.drawn = last.facts.splatsAllowed;
    timing.ms = backend_.frameMs(last.slot->recorded);
    if (last.frame->shape.eye == 0) return timing;
    const Finished first = firstEyeOf(set, last.facts);
    return first ? timing.ms += backend_.frameMs(first.slot->recorded), timing : FrameTiming();
}

void FrameReader::addStats(const SceneSet& set, uint64_t splatsAllowed, FrameStats& stats) {
    stats.splatsAllowed = splatsAllowed;
    const Finished last = lastFinished(set);
    if (!last) return;
    const Finished first = last.frame->shape.eye == 1 ? firstEyeOf(set, last.facts) : Finished{};
    for (const Finished& drawn : {first, last}) {
        if (!drawn) continue;
        addCounts(set, drawn, splatsAllowed, stats);
        addPassTimes(drawn, stats);
    }
}

void FrameReader::addCounts(const SceneSet& set, const Finished& drawn, uint64_t splatsAllowed, FrameStats& stats) const {
    const bool current = drawn.facts.number == drawn.slot->last.number;
    const gpu::FrameCounts counts = current ? countsOf(*drawn.slot) : drawn.slot->countsBefore;
    const auto raise = [](uint32_t& value, uint32_t other) { value = std::max(value, other); };
    stats.views += drawn.frame->shape.views;
    stats.chunks = set.filledGroups;
    stats.components = set.componentCount;
    raise(stats.componentsInView, drawn.facts.componentsInView);
    raise(stats.trianglesInView, counts.trianglesInView);
    raise(stats.trianglesFacing, counts.trianglesFacing);
    raise(stats.chunksProjected, counts.chunksProjected);
    raise(stats.splatsInView, counts.splatsInView);
    raise(stats.splatsFacing, counts.splatsFacing);
    raise(stats.splatsDrawn, counts.visible);
    stats.tileEntries += counts.tileEntries;
    stats.tilesOverflowed |= counts.tilesOverflowed != 0;
    // The GPU counts no bytes. They follow from the survivors and the layout, with the widest SH entry of all subjects for every splat.
    uint64_t shBytes = 0;
    for (const SubjectIds& subject : set.subjects) {
        stats.bytesDecided += uint64_t(subject.codes.firstPlace - subject.codes.firstParent) * 4;
        shBytes = std::max<uint64_t>(shBytes, (subject.codes.firstShIndex ? 2 : 0) + subject.codes.shWords * 4);
    }
    if (counts.splatsFacing == 0) return;
    // Splats that level of detail leaves out are not read.
    const double kept = set.ids.allSplats > 0 ? double(splatsAllowed) / set.ids.allSplats : 1;
    stats.bytesDecided += uint64_t(double(counts.chunksProjected) * gpu::kSplatGroup * 5 * kept);
    stats.bytesDecoded += uint64_t(counts.splatsFacing) * 4 + uint64_t(counts.visible) * (4 + shBytes);
}

void FrameReader::addPassTimes(const Finished& drawn, FrameStats& stats) const {
    const auto append = [&](FrameId recorded) {
        for (PassTime& pass : backend_.passTimes(recorded)) stats.passes.push_back(std::move(pass));
    };
    append(drawn.slot->recorded);
    const auto readback = readbacks_.find(drawn.frame->key);
    if (readback != readbacks_.end() && readback->second.lastNumber == drawn.facts.number) append(readback->second.copy);
}

void FrameReader::forget(const RecordedFrame& frame) {
    const auto found = readbacks_.find(frame.key);
    if (found == readbacks_.end()) return;
    backend_.destroyFrame(found->second.copy);
    readbacks_.erase(found);
}

}  // namespace dpl
