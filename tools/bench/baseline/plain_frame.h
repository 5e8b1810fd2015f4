// SPDX-License-Identifier: Apache-2.0
// The plain frame on a backend: draws one avatar or one set of general splats in one or two views, each view as a separate frame.
// Frozen (README.md).
#pragma once

#include <memory>

#include "sdk/avatar/rig.h"
#include "sdk/backend/vulkan/vk_open.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"
#include "tools/bench/baseline/plain_file.h"
#include "tools/bench/baseline/plain_records.h"
#include "tools/bench/baseline/plain_tiles.h"

namespace dpl::plain {

/** A Vulkan backend with the frozen shaders instead of the SDK's. */
Result<std::unique_ptr<Backend>> createBackend(const vk::DeviceRequest& request);

/** The embedded pack of frozen shaders, and the interface number that it was built with. */
std::span<const uint8_t> embeddedShaderPack();
uint64_t embeddedShaderInterface();

class Frame {
public:
    /** `backend` must come from createBackend. */
    explicit Frame(std::unique_ptr<Backend> backend, PlainFill fill = PlainFill::Quads) : backend_(std::move(backend)), fill_(fill) {}
    ~Frame();
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

    /** Uploads the subject. Call one of the two, once. The avatar must be valid, as readAvatar returns it. The splats may be freed on
     *  return. */
    Status load(std::shared_ptr<const AvatarData> avatar);
    Status load(const StaticSplatData& splats);

    /** Starts the frames of the views (1 or 2, of equal size); first recreates their buffers if the size has changed. The pose must have
     *  passed checkPose; general splats ignore it. */
    Status draw(const Pose& pose, std::span<const Cameraf> views);
    /** Waits for the frames and returns one picture per view: RGBA8 premultiplied, display-referred, top row first; valid until the next
     *  draw. Returns Unsupported if the tile lists could not hold the frame. */
    Result<std::vector<std::span<const uint8_t>>> read();

    /** Pass times of the frames that were read last, one eye after the other; empty if the device has no timestamps. */
    std::vector<PassTime> passTimes() const;
    uint32_t splatsDrawn() const;  // of the eye that draws most
    uint64_t avatarBytes() const { return avatarBytes_; }
    uint64_t splatBytes() const { return splatBytes_; }
    uint64_t residentBytes() const { return backend_->residentBytes(); }
    const DeviceInfo& device() const { return backend_->info(); }

private:
    struct Buffers {  // shared by both eyes, which run one after the other
        BufferId vertices, triangles, splats, sh, posed, triangleFrames, projected, sortDepth, blockSums, counts, pairs, pairsSwap,
            histogram;
    };
    struct Eye {
        BufferId frame, palette, colourPixels, finalCounts;
        TargetId target;      // only for quads
        TileBuffers tiles;    // only for tiles
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
    std::shared_ptr<const AvatarData> avatar_;  // null for general splats
    SplatSet splats_;
    uint32_t vertexCount_ = 0, triangleCount_ = 0, widthPx_ = 0, heightPx_ = 0;
    uint64_t avatarBytes_ = 0, splatBytes_ = 0;
    Buffers buffers_;
    std::vector<BufferId> owned_;
    std::vector<Eye> eyes_;
    size_t drawn_ = 0;
    std::vector<Mat3x4f> worldFromRest_;  // this and the next two belong to the last pose
    std::vector<float> coefficients_;
    std::vector<Vec4f> nodes_;
};

}  // namespace dpl::plain
