// SPDX-License-Identifier: Apache-2.0
// The slots of an app that lends its device: whether their commands have run, and what was destroyed while they may need it.
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {

Status MetalBackend::encode(FrameId id, uint32_t slot, AppCommands commands) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end() || it->second.run != FrameRun::Encoded) return fail(Code::InvalidArgument, "the encoded frame does not exist");
    if (slot >= kAppSlots || !commands.handle) return fail(Code::InvalidArgument, "slot {} or its commands do not exist", slot);
    Frame& frame = it->second;
    if (frame.running) ended(frame);
    lastEncoded_[slot] = ++encoded_;
    freeRetired();
    DPL_RETURN_IF_ERROR(play(frame, {commands.handle}));
    DPL_RETURN_IF_ERROR(markSlot(slot, {commands.handle}));
    frame.running = true;
    frame.slot = slot;
    return {};
}

/** What is encoded with a slot ends here, and takeSlot() learns that it has run. */
Status MetalBackend::markSlot(uint32_t slot, CommandsRef commands) {
    awaited_[slot] = ++lastMark_;
    seam_->encodeSignal(commands, marks_, lastMark_);
    if (slotCommands_[slot] == commands) return {};
    seam_->release(slotCommands_[slot]);
    seam_->retain(commands.object);
    slotCommands_[slot] = commands;
    return {};
}

/** Forgets the commands of a slot. */
void MetalBackend::freeSlot(uint32_t slot) {
    for (auto& [id, frame] : frames_)
        if (frame.run == FrameRun::Encoded && frame.running && frame.slot == slot) ended(frame);
    seam_->release(slotCommands_[slot]);
    awaited_[slot] = 0;
    layerSlots_[slot].viewCount = 0;  // until setLayers(): if the new frame fails, nothing of the slot can be composed
}

Status MetalBackend::takeSlot(uint32_t slot) {
    if (slot >= kAppSlots) return fail(Code::InvalidArgument, "slot {} does not exist; there are {}", slot, kAppSlots);
    if (slotCommands_[slot]) {
        if (const Status ran = endOf(slotCommands_[slot]); !ran) {
            copies_.slotIsDropped(slot);
            freeSlot(slot);
            return ran;
        }
    }
    if (awaited_[slot] != 0 && seam_->signaledValue(marks_) < awaited_[slot])
        return fail(Code::InvalidArgument,
                    "slot {} is prepared again, but the GPU has not run the commands that were prepared with it; wait for the completion "
                    "handler of that command buffer before, or call dplMetalDropSlot if it will never run",
                    slot);
    copies_.slotHasRun(slot);
    freeSlot(slot);
    layerSlots_[slot].depths = depthsWritten();
    composes_ = 0;  // what is encoded next waits for the composes so far
    return {};
}

Status MetalBackend::dropSlot(uint32_t slot) {
    if (slot >= kAppSlots) return fail(Code::InvalidArgument, "slot {} does not exist; there are {}", slot, kAppSlots);
    copies_.slotIsDropped(slot);
    freeSlot(slot);
    seam_->release(submissions_[slot]);
    return {};
}

/** Releases an object once no commands of the app can need it: at once if no frame was encoded since it was created. */
void MetalBackend::retire(void* object, uint64_t born) {
    if (born < encoded_)
        retired_.push_back({encoded_, object});
    else
        seam_->release(object);
}

/** Releases what no commands of the app can need any more. */
void MetalBackend::freeRetired() {
    uint64_t oldest = encoded_;  // of the frames that may still run: the last one of each slot
    for (const uint64_t last : lastEncoded_)
        if (last > 0) oldest = std::min(oldest, last);
    while (!retired_.empty() && retired_.front().encoded < oldest) {
        seam_->release(retired_.front().object);
        retired_.erase(retired_.begin());
    }
}

}  // namespace dpl::mtl
