// SPDX-License-Identifier: Apache-2.0
// What Vulkan does for the slots of an app that lends its device, and for uploads between frames (sdk/backend/slotted_backend.h).
#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {

bool VulkanBackend::slotHasRun(uint32_t slot, uint64_t mark) const {
    return reinterpret_cast<const volatile uint32_t*>(marks_.mapped)[slot] == uint32_t(mark);  // the GPU writes it
}

Result<bool> VulkanBackend::slotEnded(uint32_t slot, uint64_t mark) {
    if (slotHasRun(slot, mark)) return true;
    DPL_RETURN_IF_ERROR(checkPresent());
    return false;
}

void VulkanBackend::slotIsFree(uint32_t slot, bool ran) {
    for (auto& [id, frame] : frames_) {
        if (frame.run != FrameRun::Encoded || frame.slot != slot) continue;
        if (ran && frame.running) ended(frame);
        if (!ran) frame.running = frame.timed = false, frame.unread = VK_NULL_HANDLE;  // perhaps it never ran
    }
}

Status VulkanBackend::lend(FrameId id, BufferId lent, VkBuffer buffer, uint64_t offset, uint64_t bytes) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end() || it->second.run != FrameRun::Encoded) return fail(Code::InvalidArgument, "the encoded frame does not exist");
    for (const RecordedStep& step : it->second.steps) {
        const auto* compute = std::get_if<ComputeStep>(&step.step);
        for (size_t i = 0; compute && i < compute->bindings.size(); ++i) {
            if (!(compute->bindings[i].buffer == lent)) continue;
            const VkDescriptorBufferInfo info{buffer, offset, bytes};
            VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
            write.dstSet = step.descriptors;
            write.dstBinding = uint32_t(i);
            write.descriptorCount = 1;
            write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
            write.pBufferInfo = &info;
            vk_.vkUpdateDescriptorSets(device_->device, 1, &write, 0, nullptr);
        }
    }
    return {};
}

void VulkanBackend::retire(Retirable object, uint64_t born) {
    retired_.retire(std::move(object), born, encoded(), [&](Retirable& unneeded) { free(unneeded); });
}

void VulkanBackend::freeRetired(uint64_t oldest) {
    retired_.freeBefore(oldest, [&](Retirable& object) { free(object); });
}

void VulkanBackend::free(Retirable& object) {
    if (auto* buffer = std::get_if<Buffer>(&object)) freeBuffer(*buffer);
    if (auto* target = std::get_if<Target>(&object)) freeTarget(*target);
    if (auto* frame = std::get_if<Frame>(&object)) freeFrame(*frame);
    if (auto* target = std::get_if<AppTarget>(&object)) freeAppTarget(*target);
    if (auto* pipeline = std::get_if<VkPipeline>(&object)) vk_.vkDestroyPipeline(device_->device, *pipeline, device_->allocator);
}

Status VulkanBackend::encodeCopy(const CopyQueue::Copy& copy, AppCommands commands) {
    const VkBufferCopy region{copy.fromOffset, copy.toOffset, copy.bytes};
    vk_.vkCmdCopyBuffer(static_cast<VkCommandBuffer>(commands.handle), buffers_.at(copy.from.value).buffer,
                        buffers_.at(copy.to.value).buffer, 1, &region);
    return {};
}

Status VulkanBackend::submitCopy(const CopyQueue::Copy& copy) {
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    DPL_VK(vk_.vkBeginCommandBuffer(copyCommands_, &begin));
    DPL_RETURN_IF_ERROR(encodeCopy(copy, {copyCommands_}));
    DPL_VK(vk_.vkEndCommandBuffer(copyCommands_));
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &copyCommands_;
    DPL_VK(vk_.vkResetFences(device_->device, 1, &copyFence_));
    DPL_VK(vk_.vkQueueSubmit(device_->queue, 1, &submit, copyFence_));
    return {};
}

Result<bool> VulkanBackend::submittedCopyHasRun(CopyQueue::Copy&) {
    const VkResult status = vk_.vkGetFenceStatus(device_->device, copyFence_);
    if (status != VK_SUCCESS && status != VK_NOT_READY) return failVk("vkGetFenceStatus", status);
    return status == VK_SUCCESS;
}

}  // namespace dpl::vk
