// SPDX-License-Identifier: Apache-2.0
// The renderer over any backend. It composes three parts and submits their frames:
//
//   AvatarStore   static records of each loaded subject on the device
//   FrameCache    frames recorded once for each scene set and shape
//   FrameReader   pixels and counts read back
//
// A warm frame poses the subjects, fills the mapped buffers of the next slot and submits the slot's recorded frame:
//
//   draw:  slot 0 ─► slot 1 ─► slot 2 ─► slot 0 ...   each with its own mapped buffers, fence and timestamps
//
// An app that lends its device numbers the slots itself. encodeTogether() writes the frame into the app's commands instead of submitting
// it, and says where the app's pass finds the pictures.
//
// All other buffers are shared, because the device runs one frame after the other.
#pragma once

#include "sdk/core/function_ref.h"
#include "sdk/draw/renderer.h"
#include "sdk/render/avatar_store.h"
#include "sdk/render/frame_cache.h"
#include "sdk/render/frame_reader.h"
#include "sdk/render/posed_subject.h"
#include "sdk/render/splat_writer.h"

namespace dpl {

/** A frame of the app that a draw becomes part of. */
struct AppFrame {
    uint32_t slot = 0;  // below kAppSlots; commands with the slot's earlier frames have run
    AppCommands commands;
    /** Encodes what fills `scene`: view z of the app's scene, metres, by view, row and column; for the draw's views from `firstView` on.
     * Used when FrameWants::sceneEncoded. */
    FunctionRef<Status(BufferId scene, uint32_t firstView, uint32_t viewCount)> encodeScene;
};

/** Where the picture of a view lies once the app's commands have run. Valid until the slot is used again. */
struct EncodedView {
    uint32_t widthPx = 0, heightPx = 0;
    TargetId target;      // none: tiles fill
    uint32_t view = 0;    // of the target or of tilePixels
    BufferId tilePixels;  // none: quads fill
    // Where FrameWants asked for depth:
    uint64_t tileDepthOffset = 0;  // in tilePixels, bytes; quads leave the sums in the target
    BufferId meshDepth;            // of the mesh; none: not wanted
};

class GpuRenderer final : public Renderer {
public:
    /** name() is `name` with the fill in brackets after it. */
    GpuRenderer(std::unique_ptr<Backend> backend, std::string name, Fill fill = Fill::Quads);

    std::string name() const override { return formatText("{} ({})", name_, fill_ == Fill::Tiles ? "tiles" : "quads"); }
    void setFill(Fill fill) override { fill_ = fill; }
    std::string identity() const override { return backend_->info().identity; }
    bool lost() const override { return backend_->lost(); }
    uint64_t residentBytes() const override { return backend_->residentBytes(); }
    Result<std::unique_ptr<PreparedSubject>> prepareAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) const override;
    Result<std::unique_ptr<PreparedSubject>> prepareSplats(const StaticSplatData& splats) const override;
    Result<RenderAvatarId> begin(std::unique_ptr<PreparedSubject> subject) override;
    Result<double> continueUpload(RenderAvatarId avatar, UploadSlice& slice) override { return store_.continueUpload(avatar, slice); }
    Status finishUpload(RenderAvatarId avatar) override { return store_.finishUpload(avatar); }
    void removeAvatar(RenderAvatarId avatar) override;
    Status addAll(const Renderer& other) override;
    Status drawTogether(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) override;
    /** drawTogether() into the app's commands. Returns one element a view, valid until the next call. Nothing can be read() afterwards. It
     *  neither submits nor waits; a new scene set or shape is recorded first, which allocates. */
    Result<std::span<const EncodedView>> encodeTogether(std::span<const Drawn> what, std::span<const Cameraf> views,
                                                        const FrameWants& wants, const AppFrame& app);
    /** Splats in an app's buffer (splat_writer.h): how many, and into the app's commands. */
    Result<uint32_t> writtenRows(RenderAvatarId avatar, uint32_t budget) { return writer_.rows(avatar, budget); }
    Status encodeWrite(const SplatWrite& write, const AppWrite& app) { return writer_.encode(write, app); }
    Result<std::span<const PixelView>> read(RenderAvatarId avatar) override;
    FrameTiming timing(RenderAvatarId avatar) override;
    Result<FrameStats> stats(RenderAvatarId avatar) override;
    const DeviceInfo& device() const { return backend_->info(); }

private:
    /** The last draws of a subject. A draw of several subjects belongs to the first one. */
    struct LastDraw {
        float drawnShare = 0;                   // of its splats, in the last draw that showed it
        uint32_t set = 0;                       // scene set of the last draw that belongs to it; 0: none, or that draw failed
        bool encoded = false;                   // that draw is part of an app's commands, so its pixels cannot be read
        DetailTotals splats;                    // of that draw
        uint64_t numbers[gpu::kMaxViews] = {};  // of the frames of that draw, in the order of their views
        size_t frameCount = 0;
    };
    /** One draw after all checks. */
    struct DrawCall {
        std::span<const Drawn> what;
        std::span<LoadedSubject* const> subjects;  // of `what`
        FrameViews views;
        const FrameWants& wants;
        const AppFrame* app = nullptr;  // null: the renderer submits
    };

    Status prepareFrames(RenderAvatarId id);
    Status drawOrEncode(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants, const AppFrame* app);
    FrameShape shapeOf(const DrawCall& call) const;
    Status drawFrames(SceneSet& set, const DrawCall& call, const PosedSet& posed, LastDraw& last);
    Result<uint64_t> drawFrame(SceneSet& set, const DrawCall& call, const PosedSet& posed, const FrameShape& shape);
    Status submit(RecordedFrame& frame, FrameSlot& slot);
    Status encode(const RecordedFrame& frame, const FrameSlot& slot, const AppFrame& app, bool withScene);
    void fillSlot(FrameSlot& slot, const SceneSet& set, const DrawCall& call, const PosedSet& posed, const FrameShape& shape);
    void writeScene(const FrameSlot& slot, const DrawCall& call, const FrameShape& shape);

    // The order matters: members are destroyed from last to first. The cache and the writer use the store, and the cache tells the reader
    // which frames it frees.
    std::unique_ptr<Backend> backend_;
    std::string name_;
    Fill fill_;
    AvatarStore store_;
    FrameReader reader_;
    FrameCache cache_;
    SplatWriter writer_;
    SubjectPoser poser_;
    std::map<RenderAvatarId, LastDraw> lastDraws_;
    uint64_t frameNumber_ = 0, waits_ = 0;
    EncodedView encoded_[gpu::kMaxViews];  // of the last encodeTogether()
    size_t encodedCount_ = 0;
};

}  // namespace dpl
