// SPDX-License-Identifier: Apache-2.0
// The renderer over any backend. Everything a frame needs is created by addAvatar and by the first frame of a shape
// (size, number of views, depths or not, samples a pixel); a warm frame fills two mapped buffers (views; joints and control nodes) and
// submits one recorded frame.
//
//   draw:  slot 0 ─► slot 1 ─► slot 2 ─► slot 0 ...   each with its own mapped buffers, fence and timestamps; the rest is shared, the queue
//   runs one after the other read:  waits, copies the target into mapped memory; its buffers are made when it is first called
#pragma once

#include <algorithm>
#include <map>

#include "sdk/avatar/rig.h"
#include "sdk/draw/renderer.h"
#include "sdk/render/avatar_upload.h"
#include "sdk/render/frame_ids.h"
#include "sdk/render/passes/tiles.h"
#include "sdk/visibility/components.h"
#include "sdk/visibility/detail.h"

namespace dpl {

struct GpuOptions {
    bool preciseBlending = false;
    bool cull = true;
    bool shareViews = true;
    bool quantiseDepth = true;
    Fill fill = Fill::Quads;
};

class GpuRenderer final : public Renderer {
public:
    /** `name` is what name() says, the fill in brackets behind it. */
    GpuRenderer(std::unique_ptr<Backend> backend, std::string name, const GpuOptions& options = {});
    ~GpuRenderer() override;

    std::string name() const override { return formatText("{} ({})", name_, options_.fill == Fill::Tiles ? "tiles" : "quads"); }
    void setFill(Fill fill) override { options_.fill = fill; }
    std::string identity() const override { return backend_->info().identity; }
    Result<RenderAvatarId> addAvatar(std::shared_ptr<const AvatarData> avatar) override;
    Result<RenderAvatarId> addCodedAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) override;
    Result<RenderAvatarId> addSplats(const StaticSplatData& splats) override;
    void removeAvatar(RenderAvatarId avatar) override;
    Status drawTogether(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) override;
    Result<std::span<const PixelView>> read(RenderAvatarId avatar) override;
    Result<FrameStats> stats(RenderAvatarId avatar) override;
    /** Whether nothing of the avatar is running. Never waits. */
    bool idle(RenderAvatarId avatar);
    const DeviceInfo& device() const { return backend_->info(); }

private:
    struct Shape {
        uint32_t widthPx = 0, heightPx = 0, views = 0;
        bool depth = false, meshDepth = false, sceneDepth = false;
        uint32_t eye = 0;      // 1: the second of two frames that draw a canted pair
        uint32_t samples = 1;  // a pixel
        Fill fill = Fill::Quads;
        bool operator==(const Shape&) const = default;
    };
    struct Slot {
        std::vector<BufferId> frame, palette;  // one a subject
        BufferId scene, finalCounts;
        FrameId draw;
        uint64_t number = 0;            // of the frame it drew last; 0: none
        uint32_t componentsInView = 0;  // of that frame
    };
    struct ShapedFrame {
        Shape shape;
        FrameIds ids;  // of what the slots share
        Slot slots[kFramesInFlight];
        uint32_t next = 0;
        FrameId readback[2];  // of the target; of what the tiles have filled
        std::vector<BufferId> owned;
        uint64_t firstTileDepth = 0;         // in tilePixels, bytes
        uint64_t lastUse = 0, lastRead = 0;  // numbers of frames
        bool readTiles = false;              // by the last read-back
    };
    struct LoadedAvatar {
        std::shared_ptr<const AvatarData> data;  // null: general splats
        SplatSet splats;
        SubjectIds ids;
        std::vector<BufferId> owned;
        uint64_t avatarBytes = 0, splatBytes = 0;
        Components components;
        std::vector<Mat3x4f> worldFromRest;  // of the joints, in the last frame
        DetailSubject detailSubject;         // the one or the other
        GeneralDetailSubject generalSubject;
        GeneralDetail generalDetail;
        SplatDetail detail;  // of the last frame that it was in, as is its share of the splats
        float detailShare = 0;
        uint32_t lastRow = 0;  // of the last frame that is this one's; 0: none
    };
    /** What is drawn together, in order, and the lists that a frame of it needs. */
    struct Row {
        uint32_t number = 0;
        std::vector<RenderAvatarId> members;
        std::vector<SubjectIds> subjects;  // of the members, with their places in the lists
        FrameIds ids;                      // of what does not depend on the shape
        std::vector<BufferId> owned;
        std::vector<ShapedFrame> frames;
        uint64_t drawn[gpu::kMaxViews] = {};      // numbers of the frames of the last draw, in order of the views; 0: none
        uint64_t lastUse = 0, splatsAllowed = 0;  // of the last draw
        bool holds(RenderAvatarId avatar) const { return std::find(members.begin(), members.end(), avatar) != members.end(); }
    };

    Result<TableIds> makeTable(std::vector<BufferId>& owned, const std::string& label, uint64_t cells, uint64_t sums);
    Result<BufferId> makeBuffer(std::vector<BufferId>& owned, std::string label, uint64_t bytes,
                                BufferMemory memory = BufferMemory::Device);
    template <class T>
    Result<BufferId> uploadBuffer(std::vector<BufferId>& owned, std::string label, std::span<const T> items);
    Status loadAvatar(LoadedAvatar& avatar, const CodedSplats& splats);
    Status loadSplats(LoadedAvatar& avatar, const StaticSplatData& splats);
    Status makeWorkBuffers(Row& row);
    Result<RenderAvatarId> keep(LoadedAvatar avatar, const Status& loaded);
    Result<Row*> rowOf(std::span<const Drawn> what);
    void writePalette(const LoadedAvatar& avatar, const Pose& pose, BufferId palette);
    void poseRow(Row& row, std::span<const Drawn> what, std::span<const Cameraf> views);
    Status drawFrame(Row& row, std::span<const Drawn> what, std::span<const Cameraf> views, const Shape& shape,
                     std::span<const std::span<const float>> sceneDepthM);
    Result<ShapedFrame*> frameOf(Row& row, const Shape& shape);
    Status build(const Row& row, ShapedFrame& frame);
    Status buildSlot(const Row& row, ShapedFrame& frame, Slot& slot, const std::optional<TilePlan>& tiles);
    Status buildReadback(ShapedFrame& frame, bool tiles);
    gpu::FrameCounts countsOf(const Slot& slot);
    void fill(const Row& row, Slot& slot, std::span<const Drawn> what, std::span<const Cameraf> views, const Shape& shape);
    void writeScene(const Slot& slot, const Shape& shape, std::span<const std::span<const float>> sceneDepthM);
    void freeFrame(ShapedFrame& frame);
    void freeBuffers(const std::vector<BufferId>& buffers);
    void freeRow(Row& row);
    Row* frameRow(const LoadedAvatar& avatar);
    void takePixels(const ShapedFrame& frame, size_t firstView);

    std::unique_ptr<Backend> backend_;
    std::string name_;
    GpuOptions options_;
    std::map<RenderAvatarId, LoadedAvatar> avatars_;
    std::map<uint32_t, Row> rows_;     // by number; an avatar by itself: that of the avatar
    std::vector<float> coefficients_;  // of the last pose
    std::vector<Vec4f> nodes_;
    PixelView pixels_[gpu::kMaxViews];  // of the last read
    std::vector<float> depthM_[gpu::kMaxViews], meshDepthM_[gpu::kMaxViews];
    uint32_t lastId_ = 0;  // of avatars and rows
    uint64_t frameNumber_ = 0, waits_ = 0;
};

}  // namespace dpl
