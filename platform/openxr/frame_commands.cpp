// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/frame_commands.h"

namespace dpl::xr {
namespace {

constexpr uint64_t kGpuTimeoutNs = 10'000'000'000;

}  // namespace

FrameCommands::~FrameCommands() {
    for (VkFence fence : fences_) vkDestroyFence(runtime_.device(), fence, nullptr);
    vkDestroyCommandPool(runtime_.device(), pool_, nullptr);
}

Status FrameCommands::make() {
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = runtime_.queueFamily();
    DPL_XR_OK(Calls::check(vkCreateCommandPool(runtime_.device(), &pool, nullptr, &pool_), "vkCreateCommandPool"));
    VkCommandBufferAllocateInfo buffers{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    buffers.commandPool = pool_;
    buffers.commandBufferCount = DPL_VULKAN_SLOTS;
    DPL_XR_OK(Calls::check(vkAllocateCommandBuffers(runtime_.device(), &buffers, commands_), "vkAllocateCommandBuffers"));
    VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    fence.flags = VK_FENCE_CREATE_SIGNALED_BIT;
    for (VkFence& made : fences_) DPL_XR_OK(Calls::check(vkCreateFence(runtime_.device(), &fence, nullptr, &made), "vkCreateFence"));
    return {};
}

Status FrameCommands::wait(const VkFence* fences, uint32_t count) const {
    const VkResult result = vkWaitForFences(runtime_.device(), count, fences, VK_TRUE, kGpuTimeoutNs);
    if (result == VK_TIMEOUT) return Error{DPL_ERROR_DEVICE, "the GPU did not finish a frame within 10 s; start the program again"};
    return Calls::check(result, "vkWaitForFences");
}

Status FrameCommands::begin(Frame& frame) {
    const uint32_t next = (current_ + 1) % DPL_VULKAN_SLOTS;
    VkFence fences[1 + kMaxGroups] = {fences_[next]};
    for (uint32_t g = 0; g < frame.groupCount; ++g) {
        const uint32_t slot = (nextSlot_ + g) % DPL_VULKAN_SLOTS;
        frame.groups[g].slot = slot;
        fences[1 + g] = fences_[userOfSlot_[slot]];
    }
    DPL_XR_OK(wait(fences, 1 + frame.groupCount));
    for (uint32_t g = 0; g < frame.groupCount; ++g) userOfSlot_[frame.groups[g].slot] = next;
    nextSlot_ = (nextSlot_ + frame.groupCount) % DPL_VULKAN_SLOTS;
    current_ = next;
    frame.commands = commands_[current_];
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    return Calls::check(vkBeginCommandBuffer(frame.commands, &begin), "vkBeginCommandBuffer");
}

Status FrameCommands::submit() {
    DPL_XR_OK(Calls::check(vkEndCommandBuffer(commands_[current_]), "vkEndCommandBuffer"));
    DPL_XR_OK(Calls::check(vkResetFences(runtime_.device(), 1, &fences_[current_]), "vkResetFences"));
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands_[current_];
    const VkResult result = vkQueueSubmit(runtime_.queue(), 1, &submit, fences_[current_]);
    fenceIsDead_ = result != VK_SUCCESS;
    return Calls::check(result, "vkQueueSubmit");
}

Status FrameCommands::waitForAll() {
    if (!fences_[DPL_VULKAN_SLOTS - 1]) return {};
    if (fenceIsDead_) return Calls::check(vkDeviceWaitIdle(runtime_.device()), "vkDeviceWaitIdle");
    return wait(fences_, DPL_VULKAN_SLOTS);
}

}  // namespace dpl::xr
