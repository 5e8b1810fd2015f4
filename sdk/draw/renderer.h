// SPDX-License-Identifier: Apache-2.0
// The interface that both renderers implement: the CPU's (sdk/splat) and the GPU's (sdk/render).
//
//   load:   prepareAvatar (any thread, no lock) ─► begin ─► continueUpload, again and again, or finishUpload
//   frame:  drawTogether ─► read
#pragma once

#include <cstddef>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/pass_time.h"
#include "sdk/core/result.h"
#include "sdk/draw/screen_splat.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/math/camera.h"
#include "sdk/math/placement.h"
#include "sdk/visibility/detail.h"
#include "sdk/visibility/governor.h"

namespace dpl {

constexpr size_t kMaxViews = 2;             // of one draw: two eyes
constexpr uint32_t kMaxImageSidePx = 8192;  // of a view
constexpr size_t kMaxDrawnTogether = 16;    // subjects of one draw
constexpr uint32_t kFramesInFlight = 3;     // slots of one shape: the CPU may be two frames ahead of the GPU

/** Pixels of one view in the renderer's memory, top row first: RGBA8 (premultiplied, display-referred), and view z of the splats and of the
 * posed mesh in metres, 0 = nothing; empty when not asked for. Valid until the subject is drawn, read or removed. */
struct PixelView {
    uint32_t widthPx = 0, heightPx = 0;
    std::span<const uint8_t> rgba;
    std::span<const float> depthM, meshDepthM;
};

/** The same, owning its memory. */
struct RenderedView {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<uint8_t> rgba;
    std::vector<float> depthM, meshDepthM;
};

/** What a draw makes besides colour, and the app's opaque scene that may hide splats. */
struct FrameWants {
    bool depth = false;      // of the splats
    bool meshDepth = false;  // of the posed mesh; InvalidArgument when only general splats are drawn
    /** One span a view: view z of the scene (sdk/math/scene_depth.h), metres, rows without padding. Empty: no scene. The draw copies it. */
    std::span<const float> sceneDepthM[kMaxViews] = {};
    bool sceneEncoded = false;  // an app's commands write the scene's depth (GpuRenderer::encodeTogether); sceneDepthM is not read
    bool behindScene() const { return sceneEncoded || !sceneDepthM[0].empty() || !sceneDepthM[1].empty(); }
    FrameWants(bool depth = false) : depth(depth) {}
};

/** What the last finished frame of a subject drew and cost. All 0 before the first frame. */
struct FrameStats {
    uint32_t views = 0;
    // Survivors of the GPU's tiers of culling. 0 on the CPU, which has no such tiers.
    uint32_t trianglesInView = 0, trianglesFacing = 0;
    uint32_t splatsInView = 0, splatsFacing = 0;
    uint32_t chunks = 0, chunksProjected = 0;
    // Of the scene set. The GPU does not pose components out of view; the CPU poses an avatar whole or not at all.
    uint32_t components = 0, componentsInView = 0;
    uint32_t splatsDrawn = 0;      // shown by some view; on the CPU the largest count of one view
    uint32_t tileEntries = 0;      // splat-tile pairs of all views; 0 when quads fill
    bool tilesOverflowed = false;  // the tile lists were too small for this frame, so each tile searched
    std::vector<PassTime> passes;  // GPU time in the order the passes ran; empty without timestamps
    uint64_t residentBytes = 0;    // all subjects and frames of the renderer, in the memory it draws from
    uint64_t avatarBytes = 0;      // this subject: splats, mesh, skin weights and pose correctives
    uint64_t splatBytes = 0;       // its splats alone: codes, parents and SH entries
    uint64_t keptBytes = 0;        // its copy on the CPU for Renderer::addAll(); 0 on the CPU
    uint64_t bytesDecided = 0;     // codes read to decide which splats may show
    uint64_t bytesDecoded = 0;     // codes read to decode those splats
    uint64_t splatsAllowed = 0;    // upper bound of the scene set's splats after level of detail and budget
    float detailShare = 0;         // share of this subject's splats that its last draw kept
    uint64_t waits = 0;            // draws since the renderer was made that had to wait because all slots were in flight
};

/** Bytes that posing an avatar keeps on the CPU: mesh, weights and correctives. */
inline uint64_t posingBytes(const AvatarData& a) {
    const MeshData& m = a.mesh;
    const PoseCorrectiveData& c = a.correctives;
    return m.restPositions.size() * sizeof(m.restPositions[0]) + m.colours.size() * sizeof(m.colours[0]) +
           m.jointIndices.size() * sizeof(m.jointIndices[0]) + m.jointWeights.size() * sizeof(m.jointWeights[0]) +
           m.triangles.size() * sizeof(m.triangles[0]) + (c.mean.size() + c.modes.size()) * sizeof(float) +
           c.nodeIndices.size() * sizeof(c.nodeIndices[0]) + c.nodeWeights.size() * sizeof(c.nodeWeights[0]) +
           c.nodes.size() * sizeof(c.nodes[0]);
}

/** How a GPU fills pixels: Quads rasterises and blends one quad a splat; Tiles is a compute kernel that walks each tile's splats front to
 * back. Both draw the same picture up to rounding. */
enum class Fill : uint8_t { Quads, Tiles };

using RenderAvatarId = uint32_t;

/** A subject of a draw: posed in its own space, then placed in the world. pose: not read for general splats. */
struct Drawn {
    RenderAvatarId avatar = 0;
    const Pose* pose = nullptr;
    Placement placement = {};
    uint64_t hiddenLayers = 0;  // a bit each: layers of an avatar that are not drawn
};

/** A subject that a renderer has checked and converted, ready for add() of the same renderer. */
class PreparedSubject {
public:
    virtual ~PreparedSubject() = default;
    /** Memory that the subject takes where the renderer draws from, but for what single frames and the upload need. */
    virtual uint64_t bytes() const { return 0; }
};

/** A slice of an upload: copy `from` to `to`, which has the same size and is read by the device. Both stay valid until the next call about
 *  the upload. */
struct UploadSlice {
    std::span<std::byte> to;
    std::span<const std::byte> from;
};

/** Draws posed avatars and general splats into one or two views. One thread at a time, but for prepareAvatar and prepareSplats. */
class Renderer {
public:
    virtual ~Renderer() = default;
    /** A text for people: "software (2 threads)", "vulkan: llvmpipe ... (tiles)". */
    virtual std::string name() const = 0;
    /** DeviceInfo::identity of a GPU; empty on the CPU. */
    virtual std::string identity() const { return {}; }
    /** Whether a call has found that the graphics device was lost. Nothing can be drawn or added any more. */
    virtual bool lost() const { return false; }
    /** FrameStats::residentBytes. */
    virtual uint64_t residentBytes() const { return 0; }
    /** Takes effect with the next draw. Ignored by the CPU renderer. */
    virtual void setFill(Fill) {}
    /** Takes effect with the next draw. */
    void setDetail(const DetailOptions& detail) { detail_ = detail; }

    /** The slow half of loading: checks and converts, and does not change the renderer. Any thread, also while another one draws. `splats`
     * replaces avatar->splats, which is not read. InvalidArgument: arrays do not fit. Unsupported: above a limit of the device. */
    virtual Result<std::unique_ptr<PreparedSubject>> prepareAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) const = 0;
    /** The same for general splats. */
    virtual Result<std::unique_ptr<PreparedSubject>> prepareSplats(const StaticSplatData& splats) const = 0;
    /** The short half: keeps the prepared subject and, on a GPU, makes its buffers. On a GPU it must not be drawn before it is uploaded.
     *  InvalidArgument when another renderer prepared it. */
    virtual Result<RenderAvatarId> begin(std::unique_ptr<PreparedSubject> subject) = 0;
    /** Goes on with the upload of a subject, between frames: takes the slice of the last call, which the caller has filled, and gives out
     *  the next one; an empty one if nothing can be done now, because frames must run first. Returns the share that is uploaded; at 1 the
     *  subject can be drawn. Neither submits for an app's device nor waits. */
    virtual Result<double> continueUpload(RenderAvatarId, UploadSlice& slice) {
        slice = {};
        return 1.0;
    }
    /** Uploads what is left, and waits. */
    virtual Status finishUpload(RenderAvatarId) { return {}; }
    /** begin() and finishUpload(). */
    Result<RenderAvatarId> add(std::unique_ptr<PreparedSubject> subject);
    /** Both halves in one call. addAvatar encodes avatar->splats first. */
    Result<RenderAvatarId> addAvatar(std::shared_ptr<const AvatarData> avatar);
    Result<RenderAvatarId> addCodedAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats);
    Result<RenderAvatarId> addSplats(const StaticSplatData& splats);
    virtual void removeAvatar(RenderAvatarId avatar) = 0;
    /** Adds all subjects of another renderer of this class, under the same numbers, from what that one keeps on the CPU: its device may be
     * lost. This renderer has none yet; after an error it is of no use. Numbers of frames go on. Unsupported: above a limit of this device,
     * or renderers of the CPU, which have no device to lose. */
    virtual Status addAll(const Renderer&) { return fail(Code::Unsupported, "only renderers with a graphics device can be made anew"); }

    /** Starts a frame of a scene set of up to kMaxDrawnTogether subjects. All splats are sorted together, so subjects may interlock. The
     * frame belongs to the first subject: its read() and stats() refer to it. checkDraw (check_draw.h) lists the errors. A draw allocates
     * when the scene set or the shape (size, views, wants, samples a pixel) is new; the last four scene sets are kept. It waits only when
     * kFramesInFlight frames of the shape are still running. The CPU renderer has drawn when it returns. */
    virtual Status drawTogether(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) = 0;
    /** drawTogether with one subject. */
    Status draw(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, const FrameWants& wants);
    /** The same frame without filling pixels: writes the splats of each view that pixels would be made of, farthest first, ties with the
     * later one first. InvalidArgument: as drawTogether, or there are more splats than `out` has room for. Unsupported: a renderer on a
     * GPU, which keeps them there. read() has no picture of this frame. */
    virtual Result<ScreenSplats> projectTogether(std::span<const Drawn>, std::span<const Cameraf>, std::span<ScreenSplat>) {
        return fail(Code::Unsupported, "only the CPU renderer gives projected splats");
    }
    /** Waits for the subject's last frame and returns its pixels. For files and tests; a program with a screen shows the frame without
     * reading it back. InvalidArgument when nothing was drawn. */
    virtual Result<std::span<const PixelView>> read(RenderAvatarId avatar) = 0;
    /** draw() and read() with the pixels copied into `out`, one element a view. */
    Status render(RenderAvatarId avatar, const Pose& pose, std::span<const Cameraf> views, const FrameWants& wants,
                  std::span<RenderedView> out);
    /** What a governor goes by before the next draw that belongs to the subject: on a GPU, the time between the first and the last pass of
     * the last finished frame; on the CPU, the time of the last draw. Neither waits nor allocates. Zeros when nothing was drawn. */
    virtual FrameTiming timing(RenderAvatarId) { return {}; }
    /** The splats of an avatar; null for general splats, and where a GPU keeps them. */
    virtual const CodedSplats* splatsOf(RenderAvatarId) const { return nullptr; }
    /** For measuring. Does not wait for a frame. Allocates. */
    virtual Result<FrameStats> stats(RenderAvatarId avatar) = 0;

protected:
    DetailOptions detail_;
};

}  // namespace dpl
