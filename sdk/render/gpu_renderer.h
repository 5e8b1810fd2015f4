// The renderer over any backend. Everything a frame needs is created by addAvatar and by the first frame of a shape
// (size, number of views, depth or not); a warm frame fills two mapped buffers (views; joints and control nodes), runs one recorded frame and copies pixels out.
#pragma once

#include <map>

#include "sdk/avatar/rig.h"
#include "sdk/render/frame_ids.h"
#include "sdk/render/renderer.h"

namespace dpl {

class GpuRenderer final : public Renderer {
public:
    /** `name` is what name() says. */
    GpuRenderer(std::unique_ptr<Backend> backend, std::string name, bool preciseBlending = false);
    ~GpuRenderer() override;

    std::string name() const override { return name_; }
    Result<RenderAvatarId> addAvatar(std::shared_ptr<const AvatarData> avatar) override;
    void removeAvatar(RenderAvatarId avatar) override;
    Status render(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, bool wantDepth, std::span<RenderedView> out) override;
    Result<FrameStats> stats(RenderAvatarId avatar) const override;
    const DeviceInfo& device() const { return backend_->info(); }

private:
    struct Shape {
        uint32_t widthPx = 0, heightPx = 0, views = 0;
        bool depth = false;
        bool operator==(const Shape&) const = default;
    };
    struct ShapedFrame {
        Shape shape;
        FrameIds ids;
        FrameId frame;
        std::vector<BufferId> owned;
        uint64_t lastUse = 0;
    };
    struct LoadedAvatar {
        std::shared_ptr<const AvatarData> data;
        FrameIds ids;                  // of what does not depend on the shape
        std::vector<BufferId> owned;
        std::vector<ShapedFrame> frames;
        const ShapedFrame* lastDrawn() const;
    };

    Result<BufferId> makeBuffer(std::vector<BufferId>& owned, std::string label, uint64_t bytes, BufferMemory memory = BufferMemory::Device);
    template <class T>
    Result<BufferId> uploadBuffer(std::vector<BufferId>& owned, std::string label, std::span<const T> items);
    Status load(LoadedAvatar& avatar);
    Result<ShapedFrame*> frameOf(LoadedAvatar& avatar, const Shape& shape);
    Status build(const LoadedAvatar& avatar, ShapedFrame& frame);
    void freeFrame(ShapedFrame& frame);
    void freeAvatar(LoadedAvatar& avatar);
    void copyOut(const ShapedFrame& frame, std::span<RenderedView> out);

    std::unique_ptr<Backend> backend_;
    std::string name_;
    bool preciseBlending_;
    std::map<RenderAvatarId, LoadedAvatar> avatars_;
    std::vector<Mat3x4f> worldFromRest_;   // of the last pose, as are these
    std::vector<float> coefficients_;
    std::vector<Vec4f> nodes_;
    RenderAvatarId lastId_ = 0;
    uint64_t frameNumber_ = 0;
};

}  // namespace dpl
