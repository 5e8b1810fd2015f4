// SPDX-License-Identifier: Apache-2.0
// What Vulkan and Metal share of AppBackend: the slots of an app, the age of objects that its commands may need, queued copies, and which
// pictures a slot holds. The virtual functions at the end are what each graphics API does itself.
#pragma once

#include <algorithm>
#include <array>
#include <map>

#include "sdk/backend/app_backend.h"
#include "sdk/backend/copy_queue.h"
#include "sdk/backend/frame_check.h"
#include "sdk/backend/retired_objects.h"
#include "shaders/shared/frame.h"

namespace dpl {

/** What does not depend on the graphics API in a composer. */
struct ComposerFacts {
    bool linear = false;                        // the pass blends linear light; else display-referred values
    uint32_t layers = 0;                        // of the pass; 0: a draw composes one view
    PictureDepth written = PictureDepth::None;  // by composeDepth()
};

/** A picture to compose, by one draw of a triangle for each element of `pushes`. */
struct PictureDraw {
    ComposerId composer;
    uint32_t slot = 0;
    bool depth = false;            // writes depth; else colour
    bool greaterIsNearer = false;  // in the depth that it writes
    uint32_t layers = 0;           // of the pass; 0: no layers
    PicturePlace place;
    std::array<gpu::ComposePush, gpu::kMaxViews> push;  // view: which one of the slot the draw reads
    uint32_t draws = 0;                                 // elements of `push`
};

/** The depth image of an app behind one view, whose handle the backends add. */
struct ScenePlace {
    uint32_t layer = 0;
    int32_t x = 0, y = 0;  // of the view's top left pixel in the image
    DepthProjection stored;
};

/** A conversion of an app's depth image into view z: widthPx · heightPx floats of `scene`, those of `viewOfFrame`. */
struct SceneRead {
    uint32_t slot = 0;
    uint32_t view = 0;  // number of the image among those of the slot
    uint32_t viewOfFrame = 0;
    uint32_t widthPx = 0, heightPx = 0;  // of the view
    BufferId scene;
    AppCommands commands;
};

gpu::ScenePush scenePush(const SceneRead& read, const ScenePlace& from);

class SlottedBackend : public AppBackend, protected ResourceView {
public:
    Status takeSlot(uint32_t slot) final;
    Status dropSlot(uint32_t slot) final;
    Result<uint64_t> joinSlot(uint32_t slot) const final;
    Status encodeCopies(uint32_t slot, AppCommands commands, bool endsSlot) final;
    Result<uint64_t> queueCopy(BufferId from, uint64_t fromOffset, BufferId to, uint64_t toOffset, uint64_t bytes) final;
    Result<bool> hasRun(uint64_t copy) final;
    Status setLayers(uint32_t slot, std::span<const LayerPlace> places) final;
    uint32_t depthsWritten() const final;
    Status destroyComposer(ComposerId composer) final;
    Status compose(ComposerId composer, uint32_t slot, uint32_t view, PicturePlace place, PassCommands pass) final;
    Status composeDepth(ComposerId composer, uint32_t slot, uint32_t view, PicturePlace place, DepthProjection depth,
                        PassCommands pass) final;
    uint32_t lastNumber() const final { return lastId_; }
    void numberAfter(uint32_t number) final { lastId_ = std::max(lastId_, number); }

protected:
    /** What errors say. */
    struct Words {
        std::string_view wait;   // how an app waits for a slot, or drops it
        std::string_view begin;  // how a frame begins a slot
        std::string_view pass;   // struct of the public interface that describes a pass
    };
    explicit SlottedBackend(const Words& words) : words_(words) {}

    uint32_t newId() { return ++lastId_; }
    ComposerId addComposer(const ComposerFacts& facts);
    /** The number of the last frame that was encoded: when an object is born, and when it retires. */
    uint64_t encoded() const { return encoded_; }

    /** Before anything is encoded with a slot. InvalidArgument: no such slot, or no commands. */
    Status beginSlot(uint32_t slot, AppCommands commands);
    /** What is encoded with a slot ends here: later commands see what it wrote, and takeSlot() learns that it has run. */
    void endSlot(uint32_t slot, AppCommands commands);
    /** Lets takeSlot() see that the commands before have run. */
    void markSlot(uint32_t slot, AppCommands commands);
    /** Forgets the copies from or to a buffer that is about to go. An app's commands may still have them; then the buffer is retired. */
    void dropCopies(BufferId id);
    /** Whether a copy that the backend submitted itself was not seen to have run. */
    bool copyRuns() { return !lent() && copies_.front() && copies_.front()->running; }

private:
    /** Of the graphics API. A mark is a number, greater than those before, that the GPU writes when it comes to it. */
    virtual bool lent() const = 0;  // the device is an app's
    virtual void writeMark(uint32_t slot, uint64_t mark, AppCommands commands) = 0;
    /** Whether the commands of a slot up to its mark have run, for takeSlot(). Device: they failed, or the device was lost. */
    virtual Result<bool> slotEnded(uint32_t slot, uint64_t mark) = 0;
    /** The same for copies, which must not be forgotten if the commands failed. Never an error. */
    virtual bool slotHasRun(uint32_t slot, uint64_t mark) const = 0;
    /** The slot is free: its frames have run, or perhaps they never did. */
    virtual void slotIsFree(uint32_t slot, bool ran) = 0;
    virtual void freeRetired(uint64_t oldest) = 0;
    virtual void barrierAfterSlot(AppCommands) {}     // before the app's passes and our next frame
    virtual void barrierBeforeCopies(AppCommands) {}  // copies whose slot was dropped may run twice
    virtual Status encodeCopy(const CopyQueue::Copy& copy, AppCommands commands) = 0;
    virtual void setWritten(BufferId buffer) = 0;
    // On a device of the backend's own.
    virtual Status submitCopy(const CopyQueue::Copy& copy) = 0;
    virtual Result<bool> submittedCopyHasRun(CopyQueue::Copy& copy) = 0;
    virtual void waitForCopy() = 0;
    // Pictures.
    /** Whether all views of such a target are layers of one image, so that one draw composes them. */
    virtual bool viewsShareImage(const TargetDesc& target) const = 0;
    virtual void setLayer(uint32_t slot, uint32_t view, const LayerPlace& place) = 0;
    virtual Status drawPicture(const PictureDraw& what, PassCommands pass) = 0;
    virtual void retireComposer(ComposerId composer) = 0;

    void freeSlot(uint32_t slot, bool ran);
    Status submitNextCopy();
    Result<PictureDraw> pictureOf(ComposerId composer, uint32_t slot, uint32_t view) const;

    struct Slot {
        uint64_t lastEncoded = 0;                    // number of its last frame; 0: none
        uint64_t freed = 0;                          // times that it was taken or dropped
        uint64_t awaited = 0;                        // its last mark, which takeSlot() has not seen; 0: none
        uint32_t viewCount = 0;                      // of its pictures; 0: setLayers() has said nothing yet
        uint32_t depths = 0;                         // depthsWritten() of takeSlot()
        bool mesh = false;                           // the pictures have a depth of the mesh
        gpu::ComposePush push[gpu::kMaxViews] = {};  // of each view; views: those that one draw can compose
    };
    const Words words_;
    std::array<Slot, kAppSlots> slots_;
    uint64_t encoded_ = 0, lastMark_ = 0;
    CopyQueue copies_;
    std::map<uint32_t, ComposerFacts> composers_;
    uint32_t lastId_ = 0;
};

}  // namespace dpl
