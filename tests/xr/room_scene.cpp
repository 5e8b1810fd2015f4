// SPDX-License-Identifier: Apache-2.0
#include "tests/xr/room_scene.h"

#include <cstring>

namespace dpl::test {

using doppel::Error;
using doppel::Result;
using doppel::Status;

Status RoomScene::begin(const xr::SessionImages& images) {
    ++begun;
    if (failNextBegin) {
        failNextBegin = false;
        return Error{DPL_ERROR_UNSUPPORTED, "the scene does not want to begin"};
    }
    colourFormat = images.colourFormat, depthFormat_ = images.depthFormat;
    multiview = images.multiview, blend = images.blend;
    if (passColour_ != colourFormat || passDepth_ != depthFormat_) destroyPasses();
    passColour_ = colourFormat, passDepth_ = depthFormat_;
    for (const xr::GroupImages& from : images.groups) {
        auto passes = passesFor(images.multiview && from.views > 1 && from.passes == 1 ? (1u << from.views) - 1 : 0);
        if (!passes) return passes.error();
        groupPasses_.push_back(*passes);
        Group& group = groups_.emplace_back(Group{from.widthPx, from.heightPx, from.passes, {}, {}, {}});
        for (uint32_t pass = 0; pass < from.passes; ++pass) {
            group.depthImages[pass] = from.depth[pass].size();
            for (VkImageView colour : from.colour[pass]) {
                for (VkImageView depth : from.depth[pass]) {
                    const VkImageView both[] = {colour, depth};
                    group.room[pass].push_back(makeFramebuffer((*passes)->room, both, from.widthPx, from.heightPx));
                }
                group.compose[pass].push_back(makeFramebuffer((*passes)->compose, {&colour, 1}, from.widthPx, from.heightPx));
            }
        }
    }
    return {};
}

void RoomScene::end() {
    ++ended;
    for (Group& group : groups_)
        for (auto* lists : {&group.room, &group.compose})
            for (auto& list : *lists)
                for (VkFramebuffer framebuffer : list) vkDestroyFramebuffer(runtime_.device(), framebuffer, nullptr);
    groups_.clear();
    groupPasses_.clear();
}

void RoomScene::destroyPasses() {
    for (const Passes& passes : passes_) {
        dplDestroyVulkanComposer(runtime_.context(), passes.composer);
        vkDestroyRenderPass(runtime_.device(), passes.room, nullptr);
        vkDestroyRenderPass(runtime_.device(), passes.compose, nullptr);
    }
    passes_.clear();
}

Status RoomScene::draw(const xr::Frame& frame) {
    if (failNextDraw) {
        failNextDraw = false;
        return Error{DPL_ERROR_UNSUPPORTED, "the scene does not want to draw"};
    }
    VkClearValue clears[2]{};
    std::memcpy(clears[0].color.float32, kPlain, sizeof kPlain);
    clears[1].depthStencil = {0, 0};  // reversed: nothing
    if (blend != xr::Blend::Opaque) std::memset(clears[0].color.float32, 0, sizeof kPlain);
    for (uint32_t g = 0; g < frame.groupCount; ++g) {
        const Group& group = groups_[g];
        const Passes& passes = *groupPasses_[g];
        const xr::GroupFrame& images = frame.groups[g];
        VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
        begin.renderPass = passes.room;
        begin.renderArea.extent = {group.widthPx, group.heightPx};
        begin.clearValueCount = 2, begin.pClearValues = clears;
        for (uint32_t pass = 0; pass < group.passes; ++pass) {
            begin.framebuffer = group.room[pass][images.colourImage[pass] * group.depthImages[pass] + images.depthImage[pass]];
            vkCmdBeginRenderPass(frame.commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
            VkClearAttachment wall[2]{{VK_IMAGE_ASPECT_COLOR_BIT, 0, {}}, {VK_IMAGE_ASPECT_DEPTH_BIT, 0, {}}};
            std::memcpy(wall[0].clearValue.color.float32, kWall, sizeof kWall);
            wall[1].clearValue.depthStencil = {kNearM / kWallM, 0};
            const uint32_t from = wallFromPx(group.widthPx);
            const VkClearRect rect{{{int32_t(from), 0}, {group.widthPx - from, group.heightPx}}, 0, 1};
            vkCmdClearAttachments(frame.commands, 2, wall, 1, &rect);
            vkCmdEndRenderPass(frame.commands);
        }
        if (avatars_.empty()) continue;
        const DplResult prepared = dplVulkanPrepare(runtime_.context(), frame.commands, images.slot, avatars_.data(),
                                                    uint32_t(avatars_.size()), images.cameras, images.views, images.depths);
        if (prepared != DPL_OK) return doppel::lastError(prepared);
        begin.renderPass = passes.compose;
        for (uint32_t pass = 0; pass < group.passes; ++pass) {
            begin.framebuffer = group.compose[pass][images.colourImage[pass]];
            vkCmdBeginRenderPass(frame.commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
            const DplResult composed = dplVulkanCompose(runtime_.context(), passes.composer, frame.commands, images.slot, pass, 0, 0);
            vkCmdEndRenderPass(frame.commands);
            if (composed != DPL_OK) return doppel::lastError(composed);
        }
    }
    return {};
}

Result<const RoomScene::Passes*> RoomScene::passesFor(uint32_t viewMask) {
    for (const Passes& passes : passes_)
        if (passes.viewMask == viewMask) return &passes;
    Passes made;
    made.viewMask = viewMask;
    made.room = makePass(true, viewMask), made.compose = makePass(false, viewMask);
    passes_.push_back(made);
    DplVulkanPass pass{};
    pass.structSize = sizeof pass;
    pass.renderPass = made.compose, pass.viewMask = viewMask, pass.colourFormat = colourFormat;
    if (const DplResult r = dplCreateVulkanComposer(runtime_.context(), &pass, &passes_.back().composer); r != DPL_OK)
        return doppel::lastError(r);
    return &passes_.back();
}

/** With depth: clears both, and leaves depth readable by the compute stage. Without: draws over the colour. */
VkRenderPass RoomScene::makePass(bool withDepth, uint32_t viewMask) const {
    VkAttachmentDescription attachments[2]{};
    attachments[0].format = colourFormat;
    attachments[0].samples = attachments[1].samples = VK_SAMPLE_COUNT_1_BIT;
    attachments[0].loadOp = withDepth ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
    attachments[0].storeOp = attachments[1].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    attachments[0].stencilLoadOp = attachments[1].stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachments[0].stencilStoreOp = attachments[1].stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachments[0].initialLayout = attachments[0].finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    attachments[1].format = depthFormat_;
    attachments[1].loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    attachments[1].finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;
    const VkAttachmentReference colour{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1, subpass.pColorAttachments = &colour;
    if (withDepth) subpass.pDepthStencilAttachment = &depth;
    const VkPipelineStageFlags drawing = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                         VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    const VkAccessFlags writes = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    const VkSubpassDependency dependencies[] = {
        {VK_SUBPASS_EXTERNAL, 0, drawing | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, drawing, writes | VK_ACCESS_SHADER_READ_BIT,
         writes | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT, 0},
        {0, VK_SUBPASS_EXTERNAL, drawing, drawing | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, writes,
         writes | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_SHADER_READ_BIT, 0}};
    VkRenderPassMultiviewCreateInfo views{VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO};
    views.subpassCount = 1, views.pViewMasks = &viewMask;
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    if (viewMask) info.pNext = &views;
    info.attachmentCount = withDepth ? 2 : 1, info.pAttachments = attachments;
    info.subpassCount = 1, info.pSubpasses = &subpass;
    info.dependencyCount = 2, info.pDependencies = dependencies;
    VkRenderPass pass = VK_NULL_HANDLE;
    vkCreateRenderPass(runtime_.device(), &info, nullptr, &pass);
    return pass;
}

VkFramebuffer RoomScene::makeFramebuffer(VkRenderPass pass, std::span<const VkImageView> views, uint32_t widthPx, uint32_t heightPx) const {
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    info.renderPass = pass;
    info.attachmentCount = uint32_t(views.size()), info.pAttachments = views.data();
    info.width = widthPx, info.height = heightPx, info.layers = 1;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    vkCreateFramebuffer(runtime_.device(), &info, nullptr, &framebuffer);
    return framebuffer;
}

}  // namespace dpl::test
