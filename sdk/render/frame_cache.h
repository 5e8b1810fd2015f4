// SPDX-License-Identifier: Apache-2.0
// Recorded frames. A scene set (subjects that are drawn together) has its lists on the device. For each shape it is drawn in, a frame
// is recorded once for every slot and then replayed.
//
//   SceneSet ─► RecordedFrame (one for each shape) ─► FrameSlot (kFramesInFlight of each): own upload and read-back buffers
//
// The cache only records: its caller fills the buffers of a slot and submits the slot's frame. The caller also makes the target of each
// frame.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

#include "sdk/core/function_ref.h"
#include "sdk/render/avatar_store.h"
#include "sdk/render/device_buffers.h"
#include "sdk/render/frame_ids.h"
#include "sdk/render/frame_target.h"
#include "sdk/render/passes/tiles.h"

namespace dpl {

/** Properties of a draw that need other buffers, another target or other steps. */
struct FrameShape {
    uint32_t widthPx = 0, heightPx = 0, views = 0;
    bool depth = false, meshDepth = false, sceneDepth = false;
    bool encoded = false;  // into an app's commands, which compose it; otherwise submitted and read back
    uint32_t eye = 0;      // 1: the second of two frames that draw a canted pair
    uint32_t samples = 1;  // of a pixel
    Fill fill = Fill::Quads;
    bool operator==(const FrameShape&) const = default;
};

/** What is known of a frame without the device. */
struct FrameFacts {
    uint64_t number = 0;  // 0: none
    uint32_t componentsInView = 0;
    uint64_t splatsAllowed = 0;
    bool endsDraw = false;  // false: the first of two frames that draw a canted pair
};

/** One of the frames in flight. */
struct FrameSlot {
    struct Upload {
        BufferId frame, palette;  // palette: none for general splats
    };
    std::vector<Upload> uploads;  // of each subject, written by the CPU before each frame
    BufferId scene;               // depth of the app's scene, also written by the CPU; none: not wanted
    BufferId finalCounts;         // FrameCounts, read back
    FrameId recorded;
    FrameFacts last;  // the last frame submitted or encoded in this slot
    // An app's frame is known to have finished only when its slot comes round. Until then, statistics are those of the frame before.
    FrameFacts before;
    gpu::FrameCounts countsBefore;
};

/** A scene set in one shape. Owns its buffers and recordings, and its target unless that is lent. Tiles fill it without a target. */
struct RecordedFrame {
    RecordedFrame(Backend& backend, const FrameShape& shape, FrameTarget target)
        : shape(shape), target(std::move(target)), buffers(backend) {}

    uint64_t key = 0;  // unique in the cache, never used again
    FrameShape shape;
    FrameIds ids;  // buffers and sizes that the slots share
    FrameTarget target;
    DeviceBuffers buffers;
    FrameSlot slots[kFramesInFlight];
    uint32_t next = 0;             // the slot of the next frame; an app numbers the slots of encoded frames itself
    uint64_t tileDepthOffset = 0;  // in ids.tilePixels, bytes
    uint64_t lastUse = 0;          // number of its last frame
};

/** A recorded frame and the slot that was submitted. Null: none. */
struct SubmittedFrame {
    const RecordedFrame* frame = nullptr;
    const FrameSlot* slot = nullptr;
    explicit operator bool() const { return frame != nullptr; }
};

/** Subjects that are drawn together, in this order, and the lists on the device that every frame of them uses. */
struct SceneSet {
    explicit SceneSet(Backend& backend) : buffers(backend) {}

    uint32_t number = 0;  // from 1
    std::vector<RenderAvatarId> members;
    std::vector<SubjectIds> subjects;               // of the members, with their places in the lists
    FrameIds ids;                                   // what does not depend on the shape
    uint32_t filledGroups = 0, componentCount = 0;  // of all members: groups with any splat; components that culling knows
    bool mayTakeFourSamples = false;                // any member may
    DeviceBuffers buffers;
    std::vector<RecordedFrame> frames;
    uint64_t lastUse = 0;  // number of its last frame

    bool holds(RenderAvatarId avatar) const { return std::find(members.begin(), members.end(), avatar) != members.end(); }
    /** The frame with this number. Null unless it is the last one of its shape, because a later one has overwritten the target. */
    SubmittedFrame submitted(uint64_t frameNumber) const;
};

/** Owns the scene sets and their frames. Backend and store must live longer. One thread at a time. */
class FrameCache {
public:
    /** onFree: called before a frame is destroyed, so that its owner can drop what it keeps for the frame. */
    FrameCache(Backend& backend, const AvatarStore& store, std::function<void(const RecordedFrame&)> onFree);
    ~FrameCache();

    /** Makes the target of a frame that quads fill and that is about to be recorded. */
    using TargetMaker = FunctionRef<Result<FrameTarget>(const TargetDesc&)>;

    /** The scene set of these subjects of the store. Creates its lists on first use. A set of one is kept as long as its avatar; of
     *  larger sets only the four drawn last are kept. Valid until one of its avatars is removed or another set is made. */
    Result<SceneSet*> sceneSet(std::span<const RenderAvatarId> members);
    /** Null when it is gone. */
    const SceneSet* find(uint32_t number) const;
    /** The frame of a shape. Recorded on first use; the four shapes drawn last are kept. Valid until another shape is recorded. */
    Result<RecordedFrame*> frame(SceneSet& set, const FrameShape& shape, TargetMaker makeTarget);
    /** Frees every scene set that holds the avatar. Waits for their frames. */
    void remove(RenderAvatarId avatar);

private:
    Status makeLists(SceneSet& set);
    TargetDesc targetOf(const FrameIds& ids, const FrameShape& shape) const;
    FrameIds idsOf(const SceneSet& set, const FrameShape& shape) const;
    Status record(const SceneSet& set, RecordedFrame& frame, const TilePlan* tiles);
    Status makeTileLists(RecordedFrame& frame, const TilePlan& tiles);
    Status recordSlot(const SceneSet& set, RecordedFrame& frame, FrameSlot& slot, const TilePlan* tiles);
    Status preparePipelines(const SceneSet& set, const RecordedFrame& frame, const TilePlan* tiles);
    void free(RecordedFrame& frame);
    void free(SceneSet& set);

    Backend& backend_;
    const AvatarStore& store_;
    std::function<void(const RecordedFrame&)> onFree_;
    std::map<uint32_t, SceneSet> sets_;  // by number
    uint32_t lastNumber_ = 0;
    uint64_t lastKey_ = 0;
};

}  // namespace dpl
