// SPDX-License-Identifier: Apache-2.0
// The interface of a backend on a device that an app lends. The app numbers its frames in flight by slots, carries our commands in its own,
// and composes our pictures in its own passes:
//
//   takeSlot ─► encodeCopies, encode ─► setLayers ─► compose, composeDepth ─► the app submits ─► takeSlot, once its commands have run
//                                                                        └──► dropSlot, if they never run
//
// What Vulkan and Metal share of it is in slotted_backend.h. What has types of the graphics API (passes, the app's depth images,
// submissions) are functions of vulkan/vk_backend.h and metal/mtl_backend.h. None of the functions here allocates, waits, locks or logs,
// but for destroyComposer.
#pragma once

#include "sdk/backend/backend.h"

namespace dpl {

/** Depths of a picture. As flags, they are what prepare has to draw. */
enum class PictureDepth : uint8_t { None = 0, Splats = 1, Mesh = 2 };

/** What draws pictures in passes of one kind. The backends make them. */
using ComposerId = GpuId<struct ComposerTag>;

/** Where the picture layer of a view lies once its frame has run. */
struct LayerPlace {
    uint32_t widthPx = 0, heightPx = 0;
    TargetId target;               // of frames that quads fill; none: tiles
    uint32_t view = 0;             // of the target or of tilePixels
    BufferId tilePixels;           // of frames that tiles fill; none: quads
    uint64_t tileDepthOffset = 0;  // of the depth sums in tilePixels, bytes
    BufferId meshDepth;            // none: the picture has no depth of the mesh
};

/** What records a pass of the app: VkCommandBuffer inside the pass, id<MTLRenderCommandEncoder>. */
struct PassCommands {
    void* handle = nullptr;
};

/** Of a picture's top left pixel in the target of a pass, px. */
struct PicturePlace {
    int32_t x = 0, y = 0;
};

/** Stored depth = scale + offset / z, view z in metres. offset is not 0. */
struct DepthProjection {
    float scale = 0, offset = 0;
};

class AppBackend : public Backend {
public:
    /** To be called before anything is encoded with the slot: the commands with its earlier frames have run, so their times can be read,
     *  and nothing of the slot can be composed until setLayers(). InvalidArgument: no such slot, or the GPU has not run the commands yet;
     *  then nothing changes. Device: these commands failed; then the slot is free, and unless lost(), it may be taken again. */
    virtual Status takeSlot(uint32_t slot) = 0;
    /** The commands with the slot's earlier frames have run, or will never run. InvalidArgument: no such slot. */
    virtual Status dropSlot(uint32_t slot) = 0;
    /** For commands that join those that a frame of the app has begun with the slot: a number that is another one after each takeSlot() and
     *  dropSlot(). InvalidArgument: no such slot, or nothing was encoded with it since. */
    virtual Result<uint64_t> joinSlot(uint32_t slot) const = 0;
    /** Encodes queued copies, at most kCopiedBytesAFrame of them. To be called between takeSlot() and encode(). endsSlot: nothing is
     *  encoded after it with this slot. */
    virtual Status encodeCopies(uint32_t slot, AppCommands commands, bool endsSlot) = 0;

    /** Says where the pictures of a slot lie, one place a view, all of the same size. To be called between encode() of the slot and
     *  compose(). */
    virtual Status setLayers(uint32_t slot, std::span<const LayerPlace> places) = 0;
    /** The depths that living composers write, PictureDepth combined by |. Frames that are encoded from now on must draw them. */
    virtual uint32_t depthsWritten() const = 0;
    /** NotFound: no such composer. Commands that use it may still run. */
    virtual Status destroyComposer(ComposerId composer) = 0;
    /** Composes a view of the slot into a pass that is being recorded; in a pass of several layers, all views. Sets the state of the
     *  pipeline, of what it binds, viewport and scissor. */
    virtual Status compose(ComposerId composer, uint32_t slot, uint32_t view, PicturePlace place, PassCommands pass) = 0;
    /** The same for depth. A picture without a mesh writes nothing where the composer wants its depth. */
    virtual Status composeDepth(ComposerId composer, uint32_t slot, uint32_t view, PicturePlace place, DepthProjection depth,
                                PassCommands pass) = 0;

    /** Handles are numbers: the last one given away, and that this backend begins behind one of another backend. */
    virtual uint32_t lastNumber() const = 0;
    virtual void numberAfter(uint32_t number) = 0;
};

}  // namespace dpl
