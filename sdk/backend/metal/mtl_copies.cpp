// SPDX-License-Identifier: Apache-2.0
// Uploads in the background of frames: queued copies. An app's commands carry them if it lends its device; otherwise they are committed
// here, one at a time.
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {

Result<uint64_t> MetalBackend::queueCopy(BufferId from, uint64_t fromOffset, BufferId to, uint64_t toOffset, uint64_t bytes) {
    const auto source = buffers_.find(from.value), target = buffers_.find(to.value);
    const auto holds = [&](const auto& buffer, uint64_t offset) {
        return buffer != buffers_.end() && copies_.fits(buffer->second.desc.bytes, offset, bytes);
    };
    if (!holds(source, fromOffset) || !holds(target, toOffset))
        return fail(Code::InvalidArgument, "a copy of {} bytes from {} to {} does not fit the buffers", bytes, fromOffset, toOffset);
    const uint64_t number = copies_.add(source->second.buffer, fromOffset, target->second.buffer, toOffset, bytes);
    target->second.written = true;
    DPL_RETURN_IF_ERROR(submitNextCopy());
    return number;
}

Status MetalBackend::encodeCopy(CommandsRef commands, const Copies::Copy& copy) {
    Recorder recorder(*this, commands);
    DPL_TRY(const BlitEncoderRef encoder, recorder.blit());
    seam_->copyBuffer(encoder, copy.from, copy.fromOffset, copy.to, copy.toOffset, (copy.bytes + 3) / 4 * 4);
    return {};
}

/** On a device of the backend's own: commits the first queued copy if none runs. */
Status MetalBackend::submitNextCopy() {
    Copies::Copy* copy = copies_.front();
    if (lent_ || !copy || copy->running) return {};
    DPL_TRY(CommandsRef commands, newCommands());
    if (const Status encoded = encodeCopy(commands, *copy); !encoded) {
        seam_->release(commands);
        return encoded;
    }
    seam_->commit(commands);
    copyCommands_ = commands;
    copy->running = true;
    return {};
}

Result<bool> MetalBackend::hasRun(uint64_t number) {
    if (copyCommands_) {
        const CommandStatus status = seam_->status(copyCommands_);
        if (status == CommandStatus::Error) {
            const Status ended = endOf(copyCommands_);
            seam_->release(copyCommands_);
            copies_.front()->running = false;
            return ended.error();
        }
        if (status == CommandStatus::Completed) {
            seam_->release(copyCommands_);
            copies_.pop();
        }
    }
    DPL_RETURN_IF_ERROR(submitNextCopy());
    const Copies::Copy* copy = copies_.find(number);
    if (!copy) return true;
    // Not by the mark: when the GPU refuses a command buffer, the ones behind it still run, and their marks are greater.
    return lent_ && copy->running && slotCommands_[copy->slot] && seam_->status(slotCommands_[copy->slot]) == CommandStatus::Completed;
}

Status MetalBackend::encodeCopies(uint32_t slot, AppCommands commands, bool endsSlot) {
    if (slot >= kAppSlots || !commands.handle) return fail(Code::InvalidArgument, "slot {} or its commands do not exist", slot);
    if (!copies_.anyToEncode() && !endsSlot) return {};
    lastEncoded_[slot] = ++encoded_;
    freeRetired();
    // An encoder for each: a copy whose slot was dropped may run twice, and copies of one encoder may overlap.
    DPL_RETURN_IF_ERROR(copies_.encodeWith(slot, [&](const Copies::Copy& copy) { return encodeCopy({commands.handle}, copy); }));
    return endsSlot ? markSlot(slot, {commands.handle}) : Status();
}

/** Forgets the copies from or to a buffer that is about to go. An app's commands may still have them; then the buffer is retired. */
void MetalBackend::dropCopies(BufferRef buffer) {
    if (copyCommands_ && copies_.uses(*copies_.front(), buffer)) {
        seam_->wait(copyCommands_);
        seam_->release(copyCommands_);
    }
    copies_.drop(buffer);
}

}  // namespace dpl::mtl
