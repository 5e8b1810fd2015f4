// SPDX-License-Identifier: Apache-2.0
// The seam between the public API and whatever draws: the software renderer (sdk/splat) or a GPU backend.
#pragma once

#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/pass_time.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/math/camera.h"
#include "sdk/visibility/detail.h"

namespace dpl {

/** Pixels of one view where the renderer holds them: RGBA8 premultiplied, display-referred, top row first; depth in metres, 0 = nothing,
 *  and empty when it was not asked for; of the posed mesh likewise. Good until the avatar is drawn, read or removed. */
struct PixelView {
    uint32_t widthPx = 0, heightPx = 0;
    std::span<const uint8_t> rgba;
    std::span<const float> depthM, meshDepthM;
};

/** The same in memory of its own. */
struct RenderedView {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<uint8_t> rgba;
    std::vector<float> depthM, meshDepthM;
};

/** What a frame is to leave besides colour, and what it is drawn behind. */
struct FrameWants {
    bool depth = false;      // of the splats
    bool meshDepth = false;  // of the posed mesh; InvalidArgument for general splats, which have none
    /** Of each view: view z of an opaque scene (sdk/math/scene_depth.h), metres, tight rows; empty: none. Copied. */
    std::span<const float> sceneDepthM[2] = {};
    bool behindScene() const { return !sceneDepthM[0].empty() || !sceneDepthM[1].empty(); }
    FrameWants(bool depth = false) : depth(depth) {}
};

/** What the last finished frame of an avatar drew and cost; zeros before the first. */
struct FrameStats {
    uint32_t views = 0;
    uint32_t trianglesInView = 0,
             trianglesFacing = 0;  // survivors of each tier, splats with their triangles; 0 on the CPU, which has no tiers
    uint32_t splatsInView = 0, splatsFacing = 0;
    uint32_t chunks = 0, chunksProjected = 0;
    uint32_t components = 0,
             componentsInView =
                 0;  // of all that were drawn together; the others are not posed. On the CPU an avatar is posed whole or not at all
    uint32_t splatsDrawn = 0;      // that some view shows
    uint32_t tileEntries = 0;      // splat-tile pairs of all views; 0 when quads fill
    bool tilesOverflowed = false;  // the tiles' lists were too small for this frame: quads have filled it
    std::vector<PassTime> passes;  // GPU time in the order they ran, rounds of the sort one by one; empty without timestamps
    uint64_t residentBytes = 0;    // of all avatars and frames of the renderer, on the side that draws
    uint64_t avatarBytes = 0;      // of this avatar alone, whatever is drawn: splats, and what poses them
    uint64_t splatBytes = 0;       // of these: the splats' codes, parents and SH entries
    uint64_t bytesDecided = 0,
             bytesDecoded = 0;   // of codes that the frame read: which splats may show (phase 1), and those splats (phase 2)
    uint64_t splatsAllowed = 0;  // of all that was drawn together: what level of detail and budget left to draw at most
    float detailShare = 0;       // of this avatar's splats, the same when it was drawn last
    uint64_t waits = 0;          // since the renderer was made: draw() found every frame in flight still running
};

/** What posing an avatar keeps on the CPU: mesh, weights and correctives. */
inline uint64_t posingBytes(const AvatarData& a) {
    const MeshData& m = a.mesh;
    const PoseCorrectiveData& c = a.correctives;
    return m.restPositions.size() * sizeof(m.restPositions[0]) + m.colours.size() * sizeof(m.colours[0]) +
           m.jointIndices.size() * sizeof(m.jointIndices[0]) + m.jointWeights.size() * sizeof(m.jointWeights[0]) +
           m.triangles.size() * sizeof(m.triangles[0]) + (c.mean.size() + c.modes.size()) * sizeof(float) +
           c.nodeIndices.size() * sizeof(c.nodeIndices[0]) + c.nodeWeights.size() * sizeof(c.nodeWeights[0]) +
           c.nodes.size() * sizeof(c.nodes[0]);
}
/** How a GPU fills pixels: one blended quad a splat, or compute tiles that walk their splats front to back. The pictures agree. */
enum class Fill : uint8_t { Quads, Tiles };

/** InvalidArgument for a scene that is smaller than its view. */
inline Status checkScene(const FrameWants& wants, std::span<const Cameraf> views) {
    for (size_t v = 0; v < views.size() && v < std::size(wants.sceneDepthM); ++v)
        if (const size_t given = wants.sceneDepthM[v].size(), pixels = size_t(views[v].widthPx) * views[v].heightPx;
            given != 0 && given < pixels)
            return fail(Code::InvalidArgument, "view {} has {} depths of the scene; {} are needed", v, given, pixels);
    return {};
}

using RenderAvatarId = uint32_t;
constexpr uint32_t kFramesInFlight = 3;  // of one shape: the CPU may be two frames ahead

/** An avatar and its pose, for one frame; the pose of general splats is not looked at. */
struct Drawn {
    RenderAvatarId avatar = 0;
    const Pose* pose = nullptr;
};
constexpr size_t kMaxDrawnTogether = 16;

/** InvalidArgument for too many avatars, none, or one twice. */
inline Status checkDrawn(std::span<const Drawn> what) {
    if (what.empty() || what.size() > kMaxDrawnTogether)
        return fail(Code::InvalidArgument, "{} avatars; 1 to {} are drawn together", what.size(), kMaxDrawnTogether);
    for (size_t i = 0; i < what.size(); ++i)
        for (size_t k = 0; k < i; ++k)
            if (what[k].avatar == what[i].avatar)
                return fail(Code::InvalidArgument, "avatar {} is named twice; it has one pose", what[i].avatar);
    return {};
}

/** Draws posed avatars and general splats into one or two views. One thread at a time. */
class Renderer {
public:
    virtual ~Renderer() = default;
    /** For people: "software (2 threads)", "vulkan: llvmpipe ... (tiles)". */
    virtual std::string name() const = 0;
    /** How a GPU fills pixels from the next draw on. A CPU has one way and takes no notice. */
    virtual void setFill(Fill) {}
    /** Level of detail and the budget of splats, from the next draw on. */
    void setDetail(const DetailOptions& detail) { detail_ = detail; }
    /** DeviceInfo::identity of a GPU; empty on the CPU. */
    virtual std::string identity() const { return {}; }
    /** Uploads or indexes an avatar; everything a frame needs is created here. */
    virtual Result<RenderAvatarId> addAvatar(std::shared_ptr<const AvatarData> avatar) = 0;
    /** The same with splats as they lie in the file (readCodedAvatar): avatar->splats is not looked at. */
    virtual Result<RenderAvatarId> addCodedAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) = 0;
    /** The same for general splats, which stand still: everything about them but their number may be freed on return. */
    virtual Result<RenderAvatarId> addSplats(const StaticSplatData& splats) = 0;
    virtual void removeAvatar(RenderAvatarId avatar) = 0;
    /** Starts a frame. All views have the same size; the pose has passed checkPose (general splats take no notice of it). Once a shape
     * (size, views, what is wanted, samples a pixel: sdk/math/coverage.h) has been drawn it allocates nothing, and it waits only when
     * kFramesInFlight frames of that shape are still running. A CPU renderer draws here. */
    Status draw(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, const FrameWants& wants) {
        const Drawn one{avatar, &pose};
        return drawTogether({&one, 1}, views, wants);
    }
    /** Draws up to kMaxDrawnTogether different avatars, a scene set, into the same views. Their splats are sorted together, so avatars may
     * embrace. The frame belongs to the first one: read() and stats() of that one describe it. A scene set allocates nothing and waits for
     * nothing once it has been drawn, as one avatar; the last four scene sets are kept. */
    virtual Status drawTogether(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) = 0;
    /** Waits for the avatar's last frame and gives its pixels. For files and tests: a program with a screen shows the frame where it is. */
    virtual Result<std::span<const PixelView>> read(RenderAvatarId avatar) = 0;
    /** Draws and copies the pixels out. */
    Status render(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, const FrameWants& wants,
                  std::span<RenderedView> out);
    /** Never waits for a frame. Allocates: for measuring. */
    virtual Result<FrameStats> stats(RenderAvatarId avatar) = 0;

protected:
    DetailOptions detail_;
};

inline Status Renderer::render(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, const FrameWants& wants,
                               std::span<RenderedView> out) {
    if (out.size() != views.size()) return fail(Code::InvalidArgument, "{} views into {} images", views.size(), out.size());
    DPL_CHECK_OK(draw(avatar, pose, views, wants));
    DPL_TRY(const std::span<const PixelView> pixels, read(avatar));
    for (size_t v = 0; v < out.size(); ++v)
        out[v] = {pixels[v].widthPx,
                  pixels[v].heightPx,
                  {pixels[v].rgba.begin(), pixels[v].rgba.end()},
                  {pixels[v].depthM.begin(), pixels[v].depthM.end()},
                  {pixels[v].meshDepthM.begin(), pixels[v].meshDepthM.end()}};
    return {};
}

}  // namespace dpl
