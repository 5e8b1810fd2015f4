// The seam between the public API and whatever draws: the software renderer (sdk/splat) or a GPU backend.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
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

using RenderAvatarId = uint32_t;

/** Draws posed avatars and general splats into one or two views. One thread at a time. */
class Renderer {
public:
    virtual ~Renderer() = default;
    /** For people: "software (2 threads)", "vulkan (llvmpipe ...)". */
    virtual std::string name() const = 0;
    /** Uploads or indexes an avatar; everything a frame needs is created here. */
    virtual Result<RenderAvatarId> addAvatar(std::shared_ptr<const AvatarData> avatar) = 0;
    /** The same for general splats, which stand still: everything about them but their number may be freed on return. */
    virtual Result<RenderAvatarId> addSplats(const StaticSplatData& splats) = 0;
    virtual void removeAvatar(RenderAvatarId avatar) = 0;
    /** Draws and reads back. All views have the same size. The pose has passed checkPose; general splats take no notice of it. */
    virtual Status render(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, bool wantDepth, std::span<RenderedView> out) = 0;
};

}  // namespace dpl
