// SPDX-License-Identifier: Apache-2.0
// Uploads in the background of frames: queued copies. An app's commands carry them if it lends its device; otherwise they are submitted
// here, one at a time.
#include <algorithm>

#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {

Result<uint64_t> VulkanBackend::queueCopy(BufferId from, uint64_t fromOffset, BufferId to, uint64_t toOffset, uint64_t bytes) {
    const auto source = buffers_.find(from.value), target = buffers_.find(to.value);
    const auto holds = [&](const auto& buffer, uint64_t offset) {
        return buffer != buffers_.end() && offset % 4 == 0 && offset <= buffer->second.desc.bytes &&
               bytes <= buffer->second.desc.bytes - offset;
    };
    if (bytes == 0 || !holds(source, fromOffset) || !holds(target, toOffset))
        return fail(Code::InvalidArgument, "a copy of {} bytes from {} to {} does not fit the buffers", bytes, fromOffset, toOffset);
    QueuedCopy copy;
    copy.number = ++lastCopy_;
    copy.from = source->second.buffer, copy.to = target->second.buffer;
    copy.region = {fromOffset, toOffset, bytes};
    copies_.push_back(copy);
    target->second.written = true;
    DPL_CHECK_OK(submitNextCopy());
    return copy.number;
}

/** On a device of the backend's own: submits the first queued copy if none runs. */
Status VulkanBackend::submitNextCopy() {
    if (device_->lent || copies_.empty() || copies_.front().running) return {};
    const QueuedCopy& copy = copies_.front();
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    DPL_VK(vk_.vkBeginCommandBuffer(copyCommands_, &begin));
    vk_.vkCmdCopyBuffer(copyCommands_, copy.from, copy.to, 1, &copy.region);
    DPL_VK(vk_.vkEndCommandBuffer(copyCommands_));
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &copyCommands_;
    DPL_VK(vk_.vkResetFences(device_->device, 1, &copyFence_));
    DPL_VK(vk_.vkQueueSubmit(device_->queue, 1, &submit, copyFence_));
    copies_.front().running = true;
    return {};
}

Result<bool> VulkanBackend::hasRun(uint64_t number) {
    const auto find = [&] { return std::find_if(copies_.begin(), copies_.end(), [&](const auto& c) { return c.number == number; }); };
    if (!device_->lent && !copies_.empty() && copies_.front().running) {
        const VkResult status = vk_.vkGetFenceStatus(device_->device, copyFence_);
        if (status != VK_SUCCESS && status != VK_NOT_READY) return failVk("vkGetFenceStatus", status);
        if (status == VK_SUCCESS) copies_.erase(copies_.begin());
    }
    DPL_CHECK_OK(submitNextCopy());
    const auto copy = find();
    if (copy == copies_.end()) return true;
    return device_->lent && copy->running && awaited_[copy->slot] != 0 && markOf(copy->slot) == awaited_[copy->slot];
}

Status VulkanBackend::encodeCopies(uint32_t slot, AppCommands commands, bool endsSlot) {
    if (slot >= kAppSlots || !commands.handle) return fail(Code::InvalidArgument, "slot {} or its commands do not exist", slot);
    const bool any = std::any_of(copies_.begin(), copies_.end(), [](const QueuedCopy& c) { return !c.running; });
    if (!any && !endsSlot) return {};
    lastEncoded_[slot] = ++encoded_;
    freeRetired();
    const auto buffer = static_cast<VkCommandBuffer>(commands.handle);
    uint64_t bytes = 0;
    for (QueuedCopy& copy : copies_) {
        if (copy.running) continue;
        if (bytes > 0 && bytes + copy.region.size > kCopiedBytesAFrame) break;
        if (bytes == 0) barrierBeforeCopies(buffer);  // a copy whose slot was dropped may run twice
        vk_.vkCmdCopyBuffer(buffer, copy.from, copy.to, 1, &copy.region);
        bytes += copy.region.size;
        copy.running = true;
        copy.slot = slot;
    }
    if (endsSlot) markSlot(slot, buffer);
    return {};
}

/** The commands with this slot have run. */
void VulkanBackend::slotHasRun(uint32_t slot) {
    std::erase_if(copies_, [&](const QueuedCopy& c) { return device_->lent && c.running && c.slot == slot; });
}

/** The commands with this slot may never run: the next frame has the copies again. */
void VulkanBackend::slotIsDropped(uint32_t slot) {
    for (QueuedCopy& copy : copies_)
        if (device_->lent && copy.slot == slot) copy.running = false;
}

/** Forgets the copies from or to a buffer that is about to go. An app's commands may still have them; then the buffer is retired. */
void VulkanBackend::dropCopies(VkBuffer buffer) {
    const auto uses = [&](const QueuedCopy& c) { return c.from == buffer || c.to == buffer; };
    if (!device_->lent && !copies_.empty() && copies_.front().running && uses(copies_.front())) (void)waitFor(copyFence_);
    std::erase_if(copies_, uses);
}

}  // namespace dpl::vk
