// SPDX-License-Identifier: Apache-2.0
// What Metal does for the slots of an app that lends its device, and for uploads between frames (sdk/backend/slotted_backend.h).
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {

Status MetalBackend::encode(FrameId id, uint32_t slot, AppCommands commands) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end() || it->second.run != FrameRun::Encoded) return fail(Code::InvalidArgument, "the encoded frame does not exist");
    DPL_RETURN_IF_ERROR(beginSlot(slot, commands));
    Frame& frame = it->second;
    if (frame.running) ended(frame);
    DPL_RETURN_IF_ERROR(play(frame, {commands.handle}));
    endSlot(slot, commands);
    frame.running = true;
    frame.slot = slot;
    return {};
}

Status MetalBackend::lend(BufferId id, BufferRef buffer, uint64_t offset) {
    const auto it = buffers_.find(id.value);
    if (it == buffers_.end() || it->second.desc.memory != BufferMemory::Lent)
        return fail(Code::InvalidArgument, "the lent buffer does not exist");
    it->second.lent = buffer, it->second.lentOffset = offset;
    return {};
}

void MetalBackend::writeMark(uint32_t slot, uint64_t mark, AppCommands given) {
    const CommandsRef commands{given.handle};
    seam_->encodeSignal(commands, marks_, mark);
    if (slotCommands_[slot] == commands) return;
    seam_->release(slotCommands_[slot]);
    seam_->retain(commands.object);
    slotCommands_[slot] = commands;
}

Result<bool> MetalBackend::slotEnded(uint32_t slot, uint64_t mark) {
    DPL_RETURN_IF_ERROR(endOf(slotCommands_[slot]));
    return seam_->signaledValue(marks_) >= mark;
}

bool MetalBackend::slotHasRun(uint32_t slot, uint64_t) const {
    // Not by the mark: when the GPU refuses a command buffer, the ones behind it still run, and their marks are greater.
    return seam_->status(slotCommands_[slot]) == CommandStatus::Completed;
}

void MetalBackend::slotIsFree(uint32_t slot, bool ran) {
    for (auto& [id, frame] : frames_)
        if (frame.run == FrameRun::Encoded && frame.running && frame.slot == slot) ended(frame);
    seam_->release(slotCommands_[slot]);
    if (ran)
        composes_ = 0;  // what is encoded next waits for the composes so far
    else
        seam_->release(submissions_[slot]);
}

void MetalBackend::freeRetired(uint64_t oldest) {
    retired_.freeBefore(oldest, [&](void* object) { seam_->release(object); });
}

Status MetalBackend::encodeCopy(CommandsRef commands, BufferRef from, uint64_t fromOffset, BufferRef to, uint64_t toOffset,
                                uint64_t bytes) {
    // An encoder for each copy: one whose slot was dropped may run twice, and copies of one encoder may overlap.
    Recorder recorder(*this, commands);
    DPL_TRY(const BlitEncoderRef encoder, recorder.blit());
    seam_->copyBuffer(encoder, from, fromOffset, to, toOffset, (bytes + 3) / 4 * 4);
    return {};
}

Status MetalBackend::encodeCopy(const CopyQueue::Copy& copy, AppCommands commands) {
    return encodeCopy({commands.handle}, buffers_.at(copy.from.value).buffer, copy.fromOffset, buffers_.at(copy.to.value).buffer,
                      copy.toOffset, copy.bytes);
}

Status MetalBackend::submitCopy(const CopyQueue::Copy& copy) {
    DPL_TRY(CommandsRef commands, newCommands());
    if (const Status encoded = encodeCopy(copy, {commands.object}); !encoded) {
        seam_->release(commands);
        return encoded;
    }
    seam_->commit(commands);
    copyCommands_ = commands;
    return {};
}

Result<bool> MetalBackend::submittedCopyHasRun(CopyQueue::Copy& copy) {
    const Status ended = endOf(copyCommands_);
    if (ended && seam_->status(copyCommands_) != CommandStatus::Completed) return false;
    seam_->release(copyCommands_);
    if (ended) return true;
    copy.running = false;  // it is submitted again
    return ended.error();
}

void MetalBackend::waitForCopy() {
    seam_->wait(copyCommands_);
    seam_->release(copyCommands_);
}

}  // namespace dpl::mtl
