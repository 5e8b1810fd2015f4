// SPDX-License-Identifier: Apache-2.0
// Reads back from the device: pixels (for files and tests), counts and times of frames. A program that never reads pixels allocates no
// read-back buffers.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "sdk/render/frame_cache.h"

namespace dpl {

/** Reads frames that a FrameCache recorded and the renderer submitted. Owns the read-back buffers and makes them when a frame is first
 *  read. The backend must live longer. One thread at a time. */
class FrameReader {
public:
    explicit FrameReader(Backend& backend) : backend_(backend) {}

    /** Waits for the frames of one draw, in the order of their views, and returns the pixels of all views. They are valid until the next
     *  read, or until one of the frames is drawn again or freed. */
    Result<std::span<const PixelView>> read(std::span<const SubmittedFrame> frames);
    /** Adds what the last finished frame of the set drew and cost; of a canted pair, both frames. splatsAllowed: of the set's last draw.
     *  Never waits. */
    void addStats(const SceneSet& set, uint64_t splatsAllowed, FrameStats& stats);
    /** Number, time and splats of the last finished draw of the set; number 0: none. Neither waits nor allocates. */
    FrameTiming timing(const SceneSet& set) const;
    /** Keeps the figures of the finished frame of an app's slot, which is about to be encoded anew. */
    void keepFinished(FrameSlot& slot) const;
    /** Drops the read-back buffers of a frame that is about to be freed. */
    void forget(const RecordedFrame& frame);

private:
    struct Readback {
        explicit Readback(Backend& backend) : buffers(backend) {}
        DeviceBuffers buffers;
        BufferId colour, depth, meshDepth;
        FrameId copy;
        uint64_t lastNumber = 0;  // of the frame that was read last
    };

    Status copy(const RecordedFrame& frame, const FrameSlot& slot, Readback& readback);
    Result<FrameId> recordCopy(const RecordedFrame& frame, Readback& readback);
    void takePixels(const RecordedFrame& frame, const Readback& readback, size_t firstView);
    void takeDepth(std::span<const std::byte> sums, size_t firstPixel, std::vector<float>& depthM) const;
    gpu::FrameCounts countsOf(const FrameSlot& slot) const;
    struct Finished {
        const RecordedFrame* frame = nullptr;
        const FrameSlot* slot = nullptr;
        FrameFacts facts;
        explicit operator bool() const { return frame != nullptr; }
    };
    FrameFacts finishedOf(const FrameSlot& slot) const;
    Finished lastFinished(const SceneSet& set) const;
    Finished firstEyeOf(const SceneSet& set, const FrameFacts& second) const;
    void addCounts(const SceneSet& set, const Finished& drawn, uint64_t splatsAllowed, FrameStats& stats) const;
    void addPassTimes(const Finished& drawn, FrameStats& stats) const;

    Backend& backend_;
    std::map<uint64_t, Readback> readbacks_;  // by RecordedFrame::key
    PixelView pixels_[gpu::kMaxViews];        // of the last read
    std::vector<float> depthM_[gpu::kMaxViews], meshDepthM_[gpu::kMaxViews];
};

}  // namespace dpl
