// SPDX-License-Identifier: Apache-2.0
// Uploads in the background of frames: queued copies. An app's commands carry them if it lends its device; otherwise they are submitted
// here, one at a time.
#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {

Result<uint64_t> VulkanBackend::queueCopy(BufferId from, uint64_t fromOffset, BufferId to, uint64_t toOffset, uint64_t bytes) {
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

void VulkanBackend::record(VkCommandBuffer commands, const Copies::Copy& copy) {
    const VkBufferCopy region{copy.fromOffset, copy.toOffset, copy.bytes};
    vk_.vkCmdCopyBuffer(commands, copy.from, copy.to, 1, &region);
}

/** On a device of the backend's own: submits the first queued copy if none runs. */
Status VulkanBackend::submitNextCopy() {
    Copies::Copy* copy = copies_.front();
    if (device_->lent || !copy || copy->running) return {};
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    DPL_VK(vk_.vkBeginCommandBuffer(copyCommands_, &begin));
    record(copyCommands_, *copy);
    DPL_VK(vk_.vkEndCommandBuffer(copyCommands_));
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &copyCommands_;
    DPL_VK(vk_.vkResetFences(device_->device, 1, &copyFence_));
    DPL_VK(vk_.vkQueueSubmit(device_->queue, 1, &submit, copyFence_));
    copy->running = true;
    return {};
}

Result<bool> VulkanBackend::hasRun(uint64_t number) {
    if (!device_->lent && copies_.front() && copies_.front()->running) {
        const VkResult status = vk_.vkGetFenceStatus(device_->device, copyFence_);
        if (status != VK_SUCCESS && status != VK_NOT_READY) return failVk("vkGetFenceStatus", status);
        if (status == VK_SUCCESS) copies_.pop();
    }
    DPL_RETURN_IF_ERROR(submitNextCopy());
    const Copies::Copy* copy = copies_.find(number);
    if (!copy) return true;
    return device_->lent && copy->running && awaited_[copy->slot] != 0 && markOf(copy->slot) == awaited_[copy->slot];
}

Status VulkanBackend::encodeCopies(uint32_t slot, AppCommands commands, bool endsSlot) {
    if (slot >= kAppSlots || !commands.handle) return fail(Code::InvalidArgument, "slot {} or its commands do not exist", slot);
    if (!copies_.anyToEncode() && !endsSlot) return {};
    lastEncoded_[slot] = ++encoded_;
    freeRetired();
    const auto buffer = static_cast<VkCommandBuffer>(commands.handle);
    if (copies_.anyToEncode()) barrierBeforeCopies(buffer);  // a copy whose slot was dropped may run twice
    DPL_RETURN_IF_ERROR(copies_.encodeWith(slot, [&](const Copies::Copy& copy) {
        record(buffer, copy);
        return Status();
    }));
    if (endsSlot) markSlot(slot, buffer);
    return {};
}

/** Forgets the copies from or to a buffer that is about to go. An app's commands may still have them; then the buffer is retired. */
void VulkanBackend::dropCopies(VkBuffer buffer) {
    const Copies::Copy* copy = copies_.front();
    if (!device_->lent && copy && copy->running && copies_.uses(*copy, buffer)) (void)waitFor(copyFence_);
    copies_.drop(buffer);
}

}  // namespace dpl::vk
