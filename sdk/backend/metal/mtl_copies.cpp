// SPDX-License-Identifier: Apache-2.0
// Uploads in the background of frames: queued copies. An app's commands carry them if it lends its device; otherwise they are committed
// here, one at a time.
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {

Result<uint64_t> MetalBackend::queueCopy(BufferId from, uint64_t fromOffset, BufferId to, uint64_t toOffset, uint64_t bytes) {
    const auto source = buffers_.find(from.value), target = buffers_.find(to.value);
    const auto holds = [&](const auto& buffer, uint64_t offset) {
        return buffer != buffers_.end() && offset % 4 == 0 && offset <= buffer->second.desc.bytes &&
               bytes <= buffer->second.desc.bytes - offset;
    };
    if (bytes == 0 || !holds(source, fromOffset) || !holds(target, toOffset))
        return fail(Code::InvalidArgument, "a copy of {} bytes from {} to {} does not fit the buffers", bytes, fromOffset, toOffset);
    copies_.push_back({++lastCopy_, source->second.buffer, target->second.buffer, fromOffset, toOffset, bytes});
    target->second.written = true;
    DPL_CHECK_OK(submitNextCopy());
    return lastCopy_;
}

Status MetalBackend::encodeCopy(CommandsRef commands, const QueuedCopy& copy) {
    Recorder recorder(*this, commands);
    DPL_TRY(const BlitEncoderRef encoder, recorder.blit());
    seam_->copyBuffer(encoder, copy.from, copy.fromOffset, copy.to, copy.toOffset, (copy.bytes + 3) / 4 * 4);
    return {};
}

/** On a device of the backend's own: commits the first queued copy if none runs. */
Status MetalBackend::submitNextCopy() {
    if (lent_ || copies_.empty() || copies_.front().running) return {};
    DPL_TRY(CommandsRef commands, newCommands());
    if (const Status encoded = encodeCopy(commands, copies_.front()); !encoded) {
        seam_->release(commands);
        return encoded;
    }
    seam_->commit(commands);
    copyCommands_ = commands;
    copies_.front().running = true;
    return {};
}

Result<bool> MetalBackend::hasRun(uint64_t number) {
    if (copyCommands_) {
        const CommandStatus status = seam_->status(copyCommands_);
        if (status == CommandStatus::Error) {
            const Status ended = endOf(copyCommands_);
            seam_->release(copyCommands_);
            copies_.front().running = false;
            return ended.error();
        }
        if (status == CommandStatus::Completed) {
            seam_->release(copyCommands_);
            copies_.erase(copies_.begin());
        }
    }
    DPL_CHECK_OK(submitNextCopy());
    const auto copy = std::find_if(copies_.begin(), copies_.end(), [&](const QueuedCopy& c) { return c.number == number; });
    if (copy == copies_.end()) return true;
    return lent_ && copy->running && awaited_[copy->slot] != 0 && seam_->signaledValue(marks_) >= awaited_[copy->slot];
}

Status MetalBackend::encodeCopies(uint32_t slot, AppCommands commands, bool endsSlot) {
    if (slot >= kAppSlots || !commands.handle) return fail(Code::InvalidArgument, "slot {} or its commands do not exist", slot);
    const bool any = std::any_of(copies_.begin(), copies_.end(), [](const QueuedCopy& c) { return !c.running; });
    if (!any && !endsSlot) return {};
    lastEncoded_[slot] = ++encoded_;
    freeRetired();
    uint64_t bytes = 0;
    for (QueuedCopy& copy : copies_) {
        if (copy.running) continue;
        if (bytes > 0 && bytes + copy.bytes > kCopiedBytesAFrame) break;
        // An encoder for each: a copy whose slot was dropped may run twice, and copies of one encoder may overlap.
        DPL_CHECK_OK(encodeCopy({commands.handle}, copy));
        bytes += copy.bytes;
        copy.running = true;
        copy.slot = slot;
    }
    return endsSlot ? markSlot(slot, {commands.handle}) : Status();
}

/** The commands with this slot have run. */
void MetalBackend::slotHasRun(uint32_t slot) {
    std::erase_if(copies_, [&](const QueuedCopy& c) { return lent_ && c.running && c.slot == slot; });
}

/** The commands with this slot may never run: the next frame has the copies again. */
void MetalBackend::slotIsDropped(uint32_t slot) {
    for (QueuedCopy& copy : copies_)
        if (lent_ && copy.slot == slot) copy.running = false;
}

/** Forgets the copies from or to a buffer that is about to go. An app's commands may still have them; then the buffer is retired. */
void MetalBackend::dropCopies(BufferRef buffer) {
    const auto uses = [&](const QueuedCopy& c) { return c.from == buffer || c.to == buffer; };
    if (copyCommands_ && uses(copies_.front())) {
        seam_->wait(copyCommands_);
        seam_->release(copyCommands_);
    }
    std::erase_if(copies_, uses);
}

}  // namespace dpl::mtl
