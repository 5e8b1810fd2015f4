// SPDX-License-Identifier: Apache-2.0
#include "platform/android/native/screen.h"

#include <algorithm>

#include "platform/android/native/rotated_view.h"

namespace dpl::android {

constexpr uint32_t kMostShadows = 4;  // of one picture

doppel::Result<std::unique_ptr<Screen>> Screen::create(platform::Device& device, DplContext context, VkSurfaceKHR surface) {
    std::unique_ptr<Screen> made(new Screen(device, context));
    DPL_SHELL_TRY(made->swapchain_, platform::Swapchain::create(device, surface, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT));
    DPL_SHELL_TRY(made->slots_, platform::FrameSlots::create(device));
    return made;
}

Screen::~Screen() {
    (void)device_.waitIdle();  // fails if the device is lost; then nothing runs on it
    for (uint32_t slot = 0; slot < DPL_VULKAN_SLOTS; ++slot) dplVulkanDropSlot(context_, slot);
    destroyImages();
    destroyPass();
}

void Screen::destroyImages() {
    for (VkFramebuffer framebuffer : framebuffers_) vkDestroyFramebuffer(device_.device(), framebuffer, nullptr);
    for (VkImageView view : views_) vkDestroyImageView(device_.device(), view, nullptr);
    framebuffers_.clear(), views_.clear();
}

void Screen::destroyPass() {
    if (passFormat_ != VK_FORMAT_UNDEFINED) dplDestroyVulkanComposer(context_, composer_);
    shadows_.reset();
    vkDestroyRenderPass(device_.device(), pass_, nullptr);
    pass_ = VK_NULL_HANDLE, passFormat_ = VK_FORMAT_UNDEFINED;
}

doppel::Status Screen::makePass(VkFormat format) {
    destroyPass();
    VkAttachmentDescription colour{};
    colour.format = format;
    colour.samples = VK_SAMPLE_COUNT_1_BIT;
    colour.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    colour.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    colour.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE, colour.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    colour.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED, colour.finalLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    // The submission waits for the image at this stage, so the change of its layout must too.
    constexpr VkPipelineStageFlags kStage = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    constexpr VkAccessFlags kAccess = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    const VkSubpassDependency before{VK_SUBPASS_EXTERNAL, 0, kStage, kStage, 0, kAccess, 0};
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = 1;
    info.pAttachments = &colour;
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 1;
    info.pDependencies = &before;
    DPL_VK_MAKE(pass_, vkCreateRenderPass, device_.device(), info);
    DPL_SHELL_TRY(shadows_, platform::FloorShadows::create(device_.handles(), {pass_, 0, 1, 0}, kMostShadows, false));
    DplVulkanPass pass{};
    pass.structSize = sizeof pass;
    pass.renderPass = pass_;
    pass.colourFormat = format;
    if (const DplResult made = dplCreateVulkanComposer(context_, &pass, &composer_); made != DPL_OK)
        return doppel::lastError(made == DPL_ERROR_DEVICE ? DPL_ERROR_DEVICE : DPL_ERROR_UNSUPPORTED);
    passFormat_ = format;
    return {};
}

doppel::Status Screen::makeImages() {
    // The swapchain has waited for the frames that used the earlier ones.
    destroyImages();
    if (swapchain_->format() != passFormat_) DPL_SHELL_OK(makePass(swapchain_->format()));
    for (VkImage image : swapchain_->images()) {
        VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
        info.image = image;
        info.viewType = VK_IMAGE_VIEW_TYPE_2D;
        info.format = swapchain_->format();
        info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        VkImageView view = VK_NULL_HANDLE;
        DPL_VK_MAKE(view, vkCreateImageView, device_.device(), info);
        views_.push_back(view);
        DPL_SHELL_TRY(const VkFramebuffer framebuffer, platform::makeFramebuffer(device_.device(), pass_, {&view, 1}, swapchain_->size()));
        framebuffers_.push_back(framebuffer);
    }
    madeFor_ = swapchain_->generation();
    return {};
}

doppel::Result<DrawnFrame> Screen::draw(VkExtent2D windowPx, const FrameRequest& request) {
    DrawnFrame drawn;
    const uint32_t slotIndex = uint32_t(frame_ % DPL_VULKAN_SLOTS);
    const platform::FrameSlot& slot = slots_->all[slotIndex];
    const VkResult waited = vkWaitForFences(device_.device(), 1, &slot.done, VK_TRUE, kMostWaitNs);
    if (waited == VK_TIMEOUT) return drawn;
    if (waited != VK_SUCCESS) return platform::vulkanError(waited, "vkWaitForFences");
    DPL_SHELL_TRY(const std::optional<uint32_t> image, swapchain_->acquire(windowPx, slot.imageReady, kMostWaitNs));
    if (!image) return drawn;
    if (madeFor_ != swapchain_->generation()) DPL_SHELL_OK(makeImages());
    ++frame_;
    DPL_SHELL_OK(record(slotIndex, *image, request, drawn.avatars));

    const VkPipelineStageFlags waitStage = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    const VkSemaphore written = swapchain_->drawn(*image);
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.waitSemaphoreCount = 1;
    submit.pWaitSemaphores = &slot.imageReady;
    submit.pWaitDstStageMask = &waitStage;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &slot.commands;
    submit.signalSemaphoreCount = 1;
    submit.pSignalSemaphores = &written;
    DPL_VK(vkResetFences(device_.device(), 1, &slot.done));
    DPL_SHELL_OK(device_.submit(submit, slot.done));
    DPL_SHELL_OK(swapchain_->present(*image));
    drawn.shown = true;
    return drawn;
}

doppel::Status Screen::setShadows(uint32_t slotIndex, const FrameRequest& request) {
    std::vector<doppel::ContactShadow> shadows;
    for (DplAvatar avatar : request.avatars) {
        if (!request.shadows || shadows.size() == kMostShadows) break;
        const auto info = doppel::filled<DplAvatarInfo>(dplGetAvatarInfo, avatar);
        if (!info) return info.error();
        if (info->jointCount == 0) continue;  // general splats
        DPL_SHELL_TRY(const doppel::ContactShadow shadow, doppel::contactShadowOf(avatar));
        shadows.push_back(shadow);
    }
    shadows_->set(slotIndex, shadows);
    return {};
}

doppel::Status Screen::record(uint32_t slotIndex, uint32_t image, const FrameRequest& request, doppel::Status& avatars) {
    const VkCommandBuffer commands = slots_->all[slotIndex].commands;
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    DPL_VK(vkBeginCommandBuffer(commands, &begin));
    // The camera is of the window, and the images may lie turned by a quarter in it.
    VkExtent2D upright = swapchain_->size();
    if (isQuarterTurn(swapchain_->transform())) std::swap(upright.width, upright.height);
    const DplCamera turned = rotatedView(fittedView(request.camera, upright), swapchain_->transform());
    bool prepared = false;
    if (request.avatars.empty()) {
        avatars = doppel::status(dplVulkanUpload(context_, commands, slotIndex));
    } else {
        DplCamera camera = turned;
        if (const DplCamera& asked = request.camera; asked.sceneDepthM) {
            const size_t pixels = size_t(asked.widthPx) * asked.heightPx;
            if (pixels == 0 || asked.sceneDepthCount < pixels)
                camera.sceneDepthCount = 0;  // the library refuses it
            else
                rotatedDepth(asked, upright, swapchain_->transform(), sceneDepth_);
            if (camera.sceneDepthCount != 0) camera.sceneDepthM = sceneDepth_.data(), camera.sceneDepthCount = sceneDepth_.size();
        }
        avatars = doppel::status(
            dplVulkanPrepare(context_, commands, slotIndex, request.avatars.data(), uint32_t(request.avatars.size()), &camera, 1, nullptr));
        prepared = bool(avatars);
        if (prepared) avatars = setShadows(slotIndex, request);
        prepared = bool(avatars);
    }
    VkClearValue clear{};
    std::copy_n(request.background, 3, clear.color.float32);
    clear.color.float32[3] = 1;
    VkRenderPassBeginInfo pass{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    pass.renderPass = pass_;
    pass.framebuffer = framebuffers_[image];
    pass.renderArea.extent = swapchain_->size();
    pass.clearValueCount = 1;
    pass.pClearValues = &clear;
    vkCmdBeginRenderPass(commands, &pass, VK_SUBPASS_CONTENTS_INLINE);
    if (prepared) shadows_->record(commands, swapchain_->size(), &turned, 1, slotIndex);
    if (prepared) avatars = doppel::status(dplVulkanCompose(context_, composer_, commands, slotIndex, 0, 0, 0));
    vkCmdEndRenderPass(commands);
    DPL_VK(vkEndCommandBuffer(commands));
    return {};
}

}  // namespace dpl::android
