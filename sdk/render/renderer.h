// The seam between the public API and whatever draws: the software renderer (sdk/splat) or a GPU backend.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/backend/backend.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

/** Pixels of one view read back to memory: RGBA8 premultiplied, display-referred, top row first; depth in metres, 0 = nothing. */
struct RenderedView {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<uint8_t> rgba;
    std::vector<float> depthM;      // only when asked for
};

/** What the last finished frame of an avatar drew and cost; zeros before the first. */
struct FrameStats {
    uint32_t views = 0;
    uint32_t splatsDrawn = 0;          // that some view shows
    std::vector<PassTime> passes;      // GPU time in the order they ran, rounds of the sort one by one; empty without timestamps
    uint64_t residentBytes = 0;        // of all avatars and frames of the renderer, on the side that draws
};

using RenderAvatarId = uint32_t;

/** Draws posed avatars into one or two views. One thread at a time. */
class Renderer {
public:
    virtual ~Renderer() = default;
    /** For people: "software (2 threads)", "vulkan (llvmpipe ...)". */
    virtual std::string name() const = 0;
    /** Uploads or indexes an avatar; everything a frame needs is created here. */
    virtual Result<RenderAvatarId> addAvatar(std::shared_ptr<const AvatarData> avatar) = 0;
    virtual void removeAvatar(RenderAvatarId avatar) = 0;
    /** Draws and reads back. All views have the same size. The pose has passed checkPose. */
    virtual Status render(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, bool wantDepth, std::span<RenderedView> out) = 0;
    /** Never waits for a frame. Allocates: for measuring. */
    virtual Result<FrameStats> stats(RenderAvatarId avatar) const = 0;
};

}  // namespace dpl
