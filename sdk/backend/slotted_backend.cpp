// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/slotted_backend.h"

namespace dpl {
namespace {

Status checkSlot(uint32_t slot) {
    if (slot < kAppSlots) return {};
    return fail(Code::InvalidArgument, "slot {} does not exist; there are {}", slot, kAppSlots);
}

Status checkCommands(uint32_t slot, AppCommands commands) {
    if (slot < kAppSlots && commands.handle) return {};
    return fail(Code::InvalidArgument, "slot {} or its commands do not exist", slot);
}

/** What a draw that composes `view` of a slot pushes, but for its place and what depends on the pass. shared: all views of a frame
 *  lie in one image or buffer, so that one draw can compose them. */
gpu::ComposePush composePush(std::span<const LayerPlace> places, uint32_t view, bool shared, bool halfDepth) {
    const LayerPlace& place = places[view];
    gpu::ComposePush push{};
    push.widthPx = place.widthPx, push.heightPx = place.heightPx;
    for (uint32_t v = 0; v < places.size(); ++v)
        if (v == view || (shared && places[v].target == place.target && places[v].tilePixels == place.tilePixels)) push.views |= 1u << v;
    push.drawnFrom = view - (shared ? place.view : 0);
    push.bufferFrom = view - place.view;
    push.tiled = place.tilePixels ? 1 : 0;
    push.firstDepth = uint32_t(place.tileDepthOffset / 4);
    push.halfDepth = halfDepth ? 1 : 0;
    return push;
}

}  // namespace

gpu::ScenePush scenePush(const SceneRead& read, const ScenePlace& from) {
    return {read.widthPx,      read.heightPx,     read.viewOfFrame * read.widthPx * read.heightPx, from.layer, float(from.x), float(from.y),
            from.stored.scale, from.stored.offset};
}

// Slots.

Status SlottedBackend::beginSlot(uint32_t slot, AppCommands commands) {
    DPL_RETURN_IF_ERROR(checkCommands(slot, commands));
    slots_[slot].lastEncoded = ++encoded_;
    uint64_t oldest = encoded_;  // of the frames that may still run: the last one of each slot
    for (const Slot& s : slots_)
        if (s.lastEncoded > 0) oldest = std::min(oldest, s.lastEncoded);
    freeRetired(oldest);
    return {};
}

void SlottedBackend::endSlot(uint32_t slot, AppCommands commands) {
    barrierAfterSlot(commands);
    if (lent()) markSlot(slot, commands);
}

void SlottedBackend::markSlot(uint32_t slot, AppCommands commands) {
    slots_[slot].awaited = ++lastMark_;
    writeMark(slot, lastMark_, commands);
}

Status SlottedBackend::takeSlot(uint32_t slot) {
    DPL_RETURN_IF_ERROR(checkSlot(slot));
    if (const uint64_t awaited = slots_[slot].awaited) {
        const Result<bool> ended = slotEnded(slot, awaited);
        if (!ended) {
            freeSlot(slot, /*ran=*/false);
            return ended.error();
        }
        if (!*ended)
            return fail(Code::InvalidArgument,
                        "slot {} is prepared again, but the GPU has not run the commands that were prepared with it; {}", slot,
                        words_.wait);
    }
    freeSlot(slot, /*ran=*/true);
    slots_[slot].depths = depthsWritten();
    return {};
}

Status SlottedBackend::dropSlot(uint32_t slot) {
    DPL_RETURN_IF_ERROR(checkSlot(slot));
    freeSlot(slot, /*ran=*/false);
    return {};
}

Result<uint64_t> SlottedBackend::joinSlot(uint32_t slot) const {
    DPL_RETURN_IF_ERROR(checkSlot(slot));
    if (slots_[slot].awaited == 0)
        return fail(Code::InvalidArgument, "slot {} was not begun; {} first, with the same slot", slot, words_.begin);
    return slots_[slot].freed;
}

void SlottedBackend::freeSlot(uint32_t slot, bool ran) {
    ran ? copies_.slotHasRun(slot) : copies_.slotIsDropped(slot);
    slots_[slot].awaited = 0;
    ++slots_[slot].freed;
    slots_[slot].viewCount = 0;  // until setLayers(): if the new frame fails, nothing of the slot can be composed
    slotIsFree(slot, ran);
}

// Uploads in the background of frames. An app's commands carry them if it lends its device; otherwise they are submitted one at a time.

Result<uint64_t> SlottedBackend::queueCopy(BufferId from, uint64_t fromOffset, BufferId to, uint64_t toOffset, uint64_t bytes) {
    const auto holds = [&](const BufferDesc* desc, uint64_t offset) { return desc && CopyQueue::fits(desc->bytes, offset, bytes); };
    if (!holds(buffer(from), fromOffset) || !holds(buffer(to), toOffset))
        return fail(Code::InvalidArgument, "a copy of {} bytes from {} to {} does not fit the buffers", bytes, fromOffset, toOffset);
    const uint64_t number = copies_.add(from, fromOffset, to, toOffset, bytes);
    setWritten(to);
    DPL_RETURN_IF_ERROR(submitNextCopy());
    return number;
}

/** On a device of the backend's own: submits the first queued copy if none runs. */
Status SlottedBackend::submitNextCopy() {
    CopyQueue::Copy* copy = copies_.front();
    if (lent() || !copy || copy->running) return {};
    DPL_RETURN_IF_ERROR(submitCopy(*copy));
    copy->running = true;
    return {};
}

Result<bool> SlottedBackend::hasRun(uint64_t number) {
    if (copyRuns()) {
        DPL_TRY(const bool ran, submittedCopyHasRun(*copies_.front()));
        if (ran) copies_.pop();
    }
    DPL_RETURN_IF_ERROR(submitNextCopy());
    const CopyQueue::Copy* copy = copies_.find(number);
    if (!copy) return true;
    if (!lent() || !copy->running) return false;
    const uint64_t awaited = slots_[copy->slot].awaited;
    return awaited != 0 && slotHasRun(copy->slot, awaited);
}

Status SlottedBackend::encodeCopies(uint32_t slot, AppCommands commands, bool endsSlot) {
    DPL_RETURN_IF_ERROR(checkCommands(slot, commands));
    if (!copies_.anyToEncode() && !endsSlot) return {};
    DPL_RETURN_IF_ERROR(beginSlot(slot, commands));
    if (copies_.anyToEncode()) barrierBeforeCopies(commands);
    DPL_RETURN_IF_ERROR(copies_.encodeWith(slot, [&](const CopyQueue::Copy& copy) { return encodeCopy(copy, commands); }));
    if (endsSlot) endSlot(slot, commands);
    return {};
}

void SlottedBackend::dropCopies(BufferId id) {
    if (copyRuns() && CopyQueue::uses(*copies_.front(), id)) waitForCopy();
    copies_.drop(id);
}

// Pictures.

ComposerId SlottedBackend::addComposer(const ComposerFacts& facts) {
    const ComposerId id{newId()};
    composers_.emplace(id.value, facts);
    return id;
}

uint32_t SlottedBackend::depthsWritten() const {
    uint32_t depths = 0;
    for (const auto& [id, composer] : composers_) depths |= uint32_t(composer.written);
    return depths;
}

Status SlottedBackend::destroyComposer(ComposerId id) {
    if (composers_.erase(id.value) == 0) return fail(Code::NotFound, "there is no composer {}", id.value);
    retireComposer(id);
    return {};
}

Status SlottedBackend::setLayers(uint32_t slot, std::span<const LayerPlace> places) {
    if (slot >= kAppSlots || places.empty() || places.size() > gpu::kMaxViews)
        return fail(Code::InvalidArgument, "slot {} with {} views does not exist", slot, places.size());
    Slot& s = slots_[slot];
    s.mesh = bool(places[0].meshDepth);
    for (uint32_t v = 0; v < places.size(); ++v) {
        const bool shared = !places[v].target || viewsShareImage(*target(places[v].target));
        setLayer(slot, v, places[v]);
        s.push[v] = composePush(places, v, shared, info().halfDepth);
    }
    s.viewCount = uint32_t(places.size());
    return {};
}

/** The draws of a composer for a view of a slot, or for all views of a pass with layers. */
Result<PictureDraw> SlottedBackend::pictureOf(ComposerId id, uint32_t slot, uint32_t view) const {
    const auto found = composers_.find(id.value);
    if (found == composers_.end()) return fail(Code::NotFound, "there is no composer {}", id.value);
    if (slot >= kAppSlots || slots_[slot].viewCount == 0) return fail(Code::InvalidArgument, "slot {} was not prepared", slot);
    const uint32_t layers = found->second.layers, prepared = slots_[slot].viewCount;
    const uint32_t first = layers ? 0 : view, count = layers ? layers : 1;
    if (count > prepared || first > prepared - count)
        return fail(Code::InvalidArgument, "{} views are wanted, but slot {} was prepared with {}", uint64_t(first) + count, slot,
                    prepared);
    PictureDraw draw{};
    draw.composer = id, draw.slot = slot, draw.layers = layers;
    uint32_t done = 0;
    for (uint32_t v = first; v < first + count; ++v) {
        if (done >> v & 1) continue;
        gpu::ComposePush& push = draw.push[draw.draws++] = slots_[slot].push[v];
        push.view = v;
        done |= push.views;
    }
    return draw;
}

Status SlottedBackend::compose(ComposerId id, uint32_t slot, uint32_t view, PicturePlace place, PassCommands pass) {
    DPL_TRY(PictureDraw draw, pictureOf(id, slot, view));
    draw.place = place;
    for (gpu::ComposePush& push : draw.push) {
        push.placeX = float(place.x), push.placeY = float(place.y);
        push.linear = composers_.at(id.value).linear ? 1 : 0;
    }
    return drawPicture(draw, pass);
}

Status SlottedBackend::composeDepth(ComposerId id, uint32_t slot, uint32_t view, PicturePlace place, DepthProjection depth,
                                    PassCommands pass) {
    DPL_TRY(PictureDraw draw, pictureOf(id, slot, view));
    const PictureDepth written = composers_.at(id.value).written;
    if (written == PictureDepth::None)
        return fail(Code::InvalidArgument, "composer {} writes no depth; set writesDepth of its {}", id.value, words_.pass);
    if (!(slots_[slot].depths & uint32_t(written)))
        return fail(Code::InvalidArgument, "slot {} was prepared before composer {} was made, so its picture lacks the depth", slot,
                    id.value);
    const bool mesh = written == PictureDepth::Mesh;
    if (mesh && !slots_[slot].mesh) return {};
    draw.place = place;
    draw.depth = true;
    draw.greaterIsNearer = depth.offset > 0;
    for (gpu::ComposePush& push : draw.push) {
        push.placeX = float(place.x), push.placeY = float(place.y);
        push.mesh = mesh ? 1 : 0;
        push.scale = depth.scale, push.offset = depth.offset;
    }
    return drawPicture(draw, pass);
}

}  // namespace dpl
