// SPDX-License-Identifier: Apache-2.0
// The plain frame on a backend: one avatar or one set of general splats, one or two views, each a frame of its own. Frozen (README.md).
#pragma once

#include <memory>

#include "sdk/avatar/rig.h"
#include "sdk/backend/vulkan/vulkan_test_options.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"
#include "tools/bench/baseline/plain_file.h"
#include "tools/bench/baseline/plain_records.h"
#include "tools/bench/baseline/plain_tiles.h"

namespace dpl::plain {

/** A Vulkan backend with the frozen shaders in place of the SDK's. */
Result<std::unique_ptr<Backend>> createBackend(VulkanTestOptions options);

/** What the frozen build embeds, and the interface it was built with. */
std::span<const uint8_t> shaderPack();
uint64_t shaderInterface();

class Frame {
public:
    /** `backend` is one of createBackend. */
    explicit Frame(std::unique_ptr<Backend> backend, PlainFill fill = PlainFill::Quads) : backend_(std::move(backend)), fill_(fill) {}
    ~Frame();
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

    /** Uploads; call one of the two, once. The avatar is valid as readAvatar promises. The splats may be freed on return.
     */
    Status load(std::shared_ptr<const AvatarData> avatar);
    Status load(const StaticSplatData& splats);

    /** Starts the frames of the views (1 or 2, of equal size), and makes their buffers when the size has changed. The pose has
     * passed checkPose; general splats ignore it. */
    Status draw(const Pose& pose, std::span<const Cameraf> views);
    /** Waits for what was drawn. One picture a view: RGBA8 premultiplied, display-referred, top row first; valid until the next draw.
     * Unsupported: the lists of tiles could not hold the frame. */
    Result<std::vector<std::span<const uint8_t>>> read();

    /** Of the frames that were read last, eye after eye; empty without timestamps. */
    std::vector<PassTime> passTimes() const;
    uint32_t splatsDrawn() const;  // of the eye that sees most
    uint64_t avatarBytes() const { return avatarBytes_; }
    uint64_t splatBytes() const { return splatBytes_; }
    uint64_t residentBytes() const { return backend_->residentBytes(); }
    const DeviceInfo& device() const { return backend_->info(); }

private:
    struct Buffers {  // what both eyes share, one after the other
        BufferId vertices, triangles, splats, sh, posed, triangleFrames, projected, sortDepth, blockSums, counts, pairs, pairsSwap,
            histogram;
    };
    struct Eye {
        BufferId frame, palette, colourPixels, finalCounts;
        TargetId target;      // of quads
        TileBuffers tiles;    // of tiles
        BufferId tileCounts;  // read back
        FrameId draw, readback;
        std::vector<BufferId> owned;
    };

    Result<BufferId> makeBuffer(std::vector<BufferId>& owned, const char* label, uint64_t bytes,
                                BufferMemory memory = BufferMemory::Device);
    template <class T>
    Result<BufferId> upload(const char* label, const std::vector<T>& items);
    Status makeWorkBuffers();
    Status build(Eye& eye, uint32_t widthPx, uint32_t heightPx);
    Status addQuads(FramePlan& plan, Eye& eye, uint32_t widthPx, uint32_t heightPx);
    Status addTiles(FramePlan& plan, Eye& eye, uint32_t widthPx, uint32_t heightPx);
    void free(Eye& eye);
    void writePalette(const Pose& pose, BufferId palette);

    std::unique_ptr<Backend> backend_;
    PlainFill fill_;
    std::shared_ptr<const AvatarData> avatar_;  // empty: general splats
    SplatSet splats_;
    uint32_t vertexCount_ = 0, triangleCount_ = 0, widthPx_ = 0, heightPx_ = 0;
    uint64_t avatarBytes_ = 0, splatBytes_ = 0;
    Buffers buffers_;
    std::vector<BufferId> owned_;
    std::vector<Eye> eyes_;
    size_t drawn_ = 0;
    std::vector<Mat3x4f> worldFromRest_;  // of the last pose, as are these
    std::vector<float> coefficients_;
    std::vector<Vec4f> nodes_;
};

}  // namespace dpl::plain
