// SPDX-License-Identifier: Apache-2.0
// Draws into images of an app with submissions of our own, on the device that it lends.
#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {
namespace {

/** Loads the images, composes into them and stores them, with all that the app's queue does before and after. */
VkSubpassDependency dependency(uint32_t from, uint32_t to, bool before) {
    constexpr VkAccessFlags kAll = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    constexpr VkAccessFlags kColour = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    constexpr VkPipelineStageFlags kEvery = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, kOutput = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    VkSubpassDependency made{from, to};
    made.srcStageMask = before ? kEvery : kOutput, made.dstStageMask = before ? kOutput : kEvery;
    made.srcAccessMask = before ? kAll : kColour, made.dstAccessMask = before ? kColour : kAll;
    return made;
}

}  // namespace

Status VulkanBackend::makeSubmissions() {
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = device_->queueFamily;
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    DPL_VK_MAKE(submissionPool_, vk_.vkCreateCommandPool(device_->device, &pool, device_->allocator, &submissionPool_));
    VkCommandBufferAllocateInfo allocation{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocation.commandPool = submissionPool_;
    allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocation.commandBufferCount = kAppSlots;
    DPL_VK(vk_.vkAllocateCommandBuffers(device_->device, &allocation, submissionCommands_.data()));
    return {};
}

Result<AppTargetId> VulkanBackend::createAppTarget(const AppTargetDesc& desc) {
    AppTarget target;
    target.desc = desc;
    if (const Status made = makeAppTarget(target); !made) {
        freeAppTarget(target);
        return made.error();
    }
    const AppTargetId id{newId()};
    appTargets_.emplace(id.value, target);
    return id;
}

Status VulkanBackend::makeAppTarget(AppTarget& target) {
    const AppTargetDesc& desc = target.desc;
    if (const auto possible = blendsLight(desc.pass); !possible) return possible.error();  // before Vulkan makes a pass that it must not
    VkAttachmentDescription attachment{};
    attachment.format = desc.pass.colour;
    attachment.samples = VkSampleCountFlagBits(desc.pass.samples);
    attachment.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
    attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    attachment.initialLayout = desc.before;
    attachment.finalLayout = desc.after;
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    const VkSubpassDependency dependencies[2] = {dependency(VK_SUBPASS_EXTERNAL, 0, true), dependency(0, VK_SUBPASS_EXTERNAL, false)};
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = info.subpassCount = 1;
    info.pAttachments = &attachment;
    info.pSubpasses = &subpass;
    info.dependencyCount = 2;
    info.pDependencies = dependencies;
    VkRenderPassMultiviewCreateInfo multiview{VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO};
    multiview.subpassCount = 1;
    multiview.pViewMasks = &desc.pass.viewMask;
    if (desc.pass.viewMask) info.pNext = &multiview;
    DPL_VK_MAKE(target.pass, vk_.vkCreateRenderPass(device_->device, &info, device_->allocator, &target.pass));
    for (uint32_t i = 0; i < desc.imageCount; ++i) {
        VkFramebufferCreateInfo framebuffer{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
        framebuffer.renderPass = target.pass;
        framebuffer.attachmentCount = framebuffer.layers = 1;
        framebuffer.pAttachments = &desc.images[i];
        framebuffer.width = desc.extent.width, framebuffer.height = desc.extent.height;
        DPL_VK_MAKE(target.framebuffers[i],
                    vk_.vkCreateFramebuffer(device_->device, &framebuffer, device_->allocator, &target.framebuffers[i]));
    }
    AppPass pass = desc.pass;
    pass.renderPass = target.pass;
    DPL_TRY(target.composer, createComposer(pass));
    return {};
}

void VulkanBackend::freeAppTarget(AppTarget& target) {
    for (VkFramebuffer framebuffer : target.framebuffers) vk_.vkDestroyFramebuffer(device_->device, framebuffer, device_->allocator);
    vk_.vkDestroyRenderPass(device_->device, target.pass, device_->allocator);
}

Status VulkanBackend::destroyAppTarget(AppTargetId id) {
    const auto it = appTargets_.find(id.value);
    if (it == appTargets_.end()) return fail(Code::NotFound, "there is no target {}", id.value);
    DPL_RETURN_IF_ERROR(destroyComposer(it->second.composer));
    retire(std::move(it->second), 0);  // a submission that runs may draw into it
    appTargets_.erase(it);
    return {};
}

Result<AppCommands> VulkanBackend::beginSubmission(AppTargetId id, uint32_t slot, uint32_t viewCount) {
    const auto it = appTargets_.find(id.value);
    if (it == appTargets_.end()) return fail(Code::NotFound, "there is no target {}", id.value);
    const AppTargetDesc& desc = it->second.desc;
    if (desc.pass.viewMask == 0 && viewCount != desc.imageCount)
        return fail(Code::InvalidArgument, "{} views for target {}, which has {} images", viewCount, id.value, desc.imageCount);
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    DPL_VK(vk_.vkResetCommandBuffer(submissionCommands_[slot], 0));  // it may be half recorded, if the last call failed
    DPL_VK(vk_.vkBeginCommandBuffer(submissionCommands_[slot], &begin));
    return AppCommands{submissionCommands_[slot]};
}

Status VulkanBackend::submitTo(AppTargetId id, uint32_t slot, PicturePlace place, const AppSubmission& how) {
    const AppTarget& target = appTargets_.at(id.value);
    const VkCommandBuffer commands = submissionCommands_[slot];
    for (uint32_t i = 0; i < target.desc.imageCount; ++i) {
        VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
        begin.renderPass = target.pass;
        begin.framebuffer = target.framebuffers[i];
        begin.renderArea.extent = target.desc.extent;
        vk_.vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
        const Status composed = compose(target.composer, slot, i, place, {commands});
        vk_.vkCmdEndRenderPass(commands);
        DPL_RETURN_IF_ERROR(composed);
    }
    markSlot(slot, {commands});
    DPL_VK(vk_.vkEndCommandBuffer(commands));
    VkTimelineSemaphoreSubmitInfo timeline{VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO};
    timeline.waitSemaphoreValueCount = uint32_t(how.waitValues.size()), timeline.pWaitSemaphoreValues = how.waitValues.data();
    timeline.signalSemaphoreValueCount = uint32_t(how.signalValues.size()), timeline.pSignalSemaphoreValues = how.signalValues.data();
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    if (!how.waitValues.empty() || !how.signalValues.empty()) submit.pNext = &timeline;
    submit.waitSemaphoreCount = uint32_t(how.waits.size()), submit.pWaitSemaphores = how.waits.data();
    submit.pWaitDstStageMask = how.waitStages.data();
    submit.signalSemaphoreCount = uint32_t(how.signals.size()), submit.pSignalSemaphores = how.signals.data();
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    const Device::QueueLock lock(*device_);
    DPL_VK(vk_.vkQueueSubmit(device_->queue, 1, &submit, how.fence));
    return {};
}

}  // namespace dpl::vk
