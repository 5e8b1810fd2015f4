// SPDX-License-Identifier: Apache-2.0
#include "apps/xr/avatar_scene.h"

#include <cmath>

namespace dpl {
namespace {

// Waist-high, before the avatar and beside it, so that a user sees that it stands among other things.
constexpr std::array<float, 2> kPosts[] = {{0.16f, -1.39f}, {-0.68f, -1.2f}};

constexpr double kTurnRadPerS = 1.6;

VkAttachmentDescription attachment(VkFormat format, VkAttachmentLoadOp load, VkImageLayout before, VkImageLayout after) {
    VkAttachmentDescription a{};
    a.format = format;
    a.samples = VK_SAMPLE_COUNT_1_BIT;
    a.loadOp = load;
    a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    a.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE, a.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    a.initialLayout = before, a.finalLayout = after;
    return a;
}

}  // namespace

AvatarScene::AvatarScene(const xr::Runtime& runtime, doppel::Avatar& avatar, xr::Puppet puppet, const SceneOptions& options)
    : runtime_(runtime), avatar_(avatar), options_(options), puppet_(std::move(puppet)) {
    const auto info = avatar.info();
    rest_.assign(info ? 4 * size_t(info->jointCount) : 0, 0.0f);
    for (size_t w = 3; w < rest_.size(); w += 4) rest_[w] = 1;
}

AvatarScene::~AvatarScene() {
    end();
}

std::array<float, 12> AvatarScene::worldFromAvatar() const {
    const XrQuaternionf& turn = worldFromAvatar_.orientation;
    const XrVector3f x = xr::rotate(turn, {1, 0, 0}), y = xr::rotate(turn, {0, 1, 0}), z = xr::rotate(turn, {0, 0, 1}),
                     &t = worldFromAvatar_.position;
    return {x.x, y.x, z.x, t.x, x.y, y.y, z.y, t.y, x.z, y.z, z.z, t.z};
}

doppel::Status AvatarScene::begin(const xr::SessionImages& images) {
    images_ = &images;
    DPL_SHELL_OK(makePasses());
    platform::RoomPlan plan;
    plan.posts.assign(std::begin(kPosts), std::end(kPosts));
    const platform::VulkanHandles device{runtime_.physicalDevice(), runtime_.device()};
    const platform::RoomPass roomPass{drawing_, 0, 1, images.multiview ? 3u : 0u};
    DPL_SHELL_TRY(room_, platform::Room::create(device, roomPass));
    DPL_SHELL_TRY(shadows_, platform::FloorShadows::create(device, roomPass, 1));
    room_->build(plan);
    for (const xr::GroupImages& group : images.groups) DPL_SHELL_OK(makeFramebuffers(group));
    DplVulkanPass pass{};
    pass.structSize = sizeof pass;
    pass.renderPass = composing_;
    pass.viewMask = images.multiview ? 3 : 0;
    pass.colourFormat = images.colourFormat;
    pass.writesDepth = DPL_DRAW_DEPTH;  // of general splats too
    uint32_t composer = 0;
    DPL_SHELL_OK(doppel::status(dplCreateVulkanComposer(runtime_.context(), &pass, &composer)));
    composer_ = composer;
    return {};
}

doppel::Status AvatarScene::makeFramebuffers(const xr::GroupImages& group) {
    const auto add = [&](std::vector<VkFramebuffer>& to, VkRenderPass pass, VkImageView colour, VkImageView depth) -> doppel::Status {
        const VkImageView views[] = {colour, depth};
        DPL_SHELL_TRY(const VkFramebuffer made, platform::makeFramebuffer(runtime_.device(), pass, views, {group.widthPx, group.heightPx}));
        framebuffers_.push_back(made);
        to.push_back(made);
        return {};
    };
    std::vector<Pass>& made = passes_.emplace_back(group.passes);
    for (uint32_t p = 0; p < group.passes; ++p)
        for (VkImageView colour : group.colour[p]) {
            auto &drawing = made[p].drawing.emplace_back(), &composing = made[p].composing.emplace_back();
            for (VkImageView depth : group.depth[p]) {
                DPL_SHELL_OK(add(drawing, drawing_, colour, depth));
                DPL_SHELL_OK(add(composing, composing_, colour, depth));
            }
        }
    return {};
}

void AvatarScene::end() {
    const VkDevice device = runtime_.device();
    for (VkFramebuffer framebuffer : framebuffers_) vkDestroyFramebuffer(device, framebuffer, nullptr);
    framebuffers_.clear(), passes_.clear();
    if (composer_) dplDestroyVulkanComposer(runtime_.context(), *composer_);
    composer_.reset();
    room_.reset(), shadows_.reset();
    vkDestroyRenderPass(device, drawing_, nullptr);
    vkDestroyRenderPass(device, composing_, nullptr);
    drawing_ = composing_ = VK_NULL_HANDLE;
    images_ = nullptr;
}

doppel::Status AvatarScene::makePasses() {
    const VkAttachmentReference colour{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    constexpr VkPipelineStageFlags kColourStage = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    constexpr VkPipelineStageFlags kDepthStages = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    constexpr VkAccessFlags kColourAccess = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    constexpr VkAccessFlags kDepthAccess = VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &colour;
    subpass.pDepthStencilAttachment = &depth;
    const uint32_t mask = 3;
    VkRenderPassMultiviewCreateInfo multiview{VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO};
    multiview.subpassCount = 1;
    multiview.pViewMasks = &mask;
    multiview.correlationMaskCount = 1;
    multiview.pCorrelationMasks = &mask;
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    if (images_->multiview) info.pNext = &multiview;
    info.subpassCount = 1;
    info.pSubpasses = &subpass;

    // The room. The avatar's compute passes read its depth afterwards, and those of the frame before may still do.
    const VkAttachmentDescription room[] = {
        attachment(images_->colourFormat, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL),
        attachment(images_->depthFormat, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_IMAGE_LAYOUT_UNDEFINED,
                   VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL)};
    const VkSubpassDependency around[] = {
        {VK_SUBPASS_EXTERNAL, 0, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | kColourStage | kDepthStages,
         kColourStage | kDepthStages, kColourAccess | kDepthAccess, kColourAccess | kDepthAccess, 0},
        {0, VK_SUBPASS_EXTERNAL, kColourStage | kDepthStages, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | kColourStage,
         kColourAccess | kDepthAccess, VK_ACCESS_SHADER_READ_BIT | kColourAccess, 0},
    };
    info.attachmentCount = 2;
    info.pAttachments = room;
    info.dependencyCount = 2;
    info.pDependencies = around;
    DPL_VK_MAKE(drawing_, vkCreateRenderPass, runtime_.device(), info);

    // The avatar: composed over both. Its compute passes have read the depth that it writes.
    const VkAttachmentDescription composed[] = {
        attachment(images_->colourFormat, VK_ATTACHMENT_LOAD_OP_LOAD, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL),
        attachment(images_->depthFormat, VK_ATTACHMENT_LOAD_OP_LOAD, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL,
                   VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL)};
    const VkSubpassDependency over[] = {
        {VK_SUBPASS_EXTERNAL, 0, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | kColourStage | kDepthStages, kColourStage | kDepthStages,
         VK_ACCESS_SHADER_READ_BIT | kColourAccess | kDepthAccess, kColourAccess | kDepthAccess, 0},
        {0, VK_SUBPASS_EXTERNAL, kColourStage | kDepthStages, kColourStage | kDepthStages, kColourAccess | kDepthAccess,
         kColourAccess | kDepthAccess, 0},
    };
    info.pAttachments = composed;
    info.pDependencies = over;
    DPL_VK_MAKE(composing_, vkCreateRenderPass, runtime_.device(), info);
    return {};
}

void AvatarScene::drawRoom(VkCommandBuffer commands, const xr::GroupImages& images, const xr::GroupFrame& group, uint32_t pass,
                           VkFramebuffer target) const {
    const bool shown = options_.withRoom && images_->blend == xr::Blend::Opaque;
    const VkClearValue clear[2]{};  // black of alpha 0, infinitely far
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = drawing_;
    begin.framebuffer = target;
    begin.renderArea.extent = {images.widthPx, images.heightPx};
    begin.clearValueCount = 2;
    begin.pClearValues = clear;
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    const DplCamera* views = group.cameras + (images_->multiview ? 0 : pass);
    const uint32_t viewCount = images_->multiview ? 2 : 1;
    if (shown) room_->record(commands, begin.renderArea.extent, views, viewCount, platform::RoomLight::Dark);
    if (shown || images_->blend == xr::Blend::Alpha)  // on the real floor, too
        shadows_->record(commands, begin.renderArea.extent, views, viewCount, group.slot);
    vkCmdEndRenderPass(commands);
}

void AvatarScene::originMoved(const XrPosef& oldFromNew) {
    using xr::operator*;
    const XrPosef newFromOld = xr::inverse(oldFromNew);
    worldFromAvatar_ = newFromOld * worldFromAvatar_;
    mirror_ = {(newFromOld * XrPosef{{0, 0, 0, 1}, mirror_.point}).position, xr::rotate(newFromOld.orientation, mirror_.normal)};
}

void AvatarScene::moveByControllers(const xr::Session& session) {
    using xr::operator*;
    if (const auto& moved = session.originMoved()) originMoved(*moved);
    XrPosef place = worldFromAvatar_;
    for (const xr::Controller& hand : session.controllers().hands) {
        const XrVector3f ray = xr::rotate(hand.aim.orientation, {0, 0, -1});
        if (hand.tracked && hand.selected && ray.y < -0.05f) {
            const float length = -hand.aim.position.y / ray.y;
            place.position = {hand.aim.position.x + length * ray.x, 0, hand.aim.position.z + length * ray.z};
        }
        const float half = float(-0.5 * kTurnRadPerS * hand.turn * session.lastFrame().periodS);
        if (hand.turn != 0) place.orientation = XrQuaternionf{0, std::sin(half), 0, std::cos(half)} * place.orientation;
    }
    if (xr::makeValid(place)) worldFromAvatar_ = place;
}

/** Where the avatar stands, and the pose of the clip, in which the user's hands, and before a mirror the head, take over. */
doppel::Status AvatarScene::poseAvatar(const xr::Frame& frame) {
    if (rest_.empty()) return avatar_.setTransform(worldFromAvatar());  // general splats
    xr::User user = options_.mirror ? xr::mirrored(mirror_, frame.user) : frame.user;
    if (!options_.withHands) {
        for (xr::Hand& hand : user.hands) hand.located = 0;
        user.body.located.reset();
    }
    const XrPosef body = stance_.of(user);
    if (options_.mirror) worldFromAvatar_ = body;
    DPL_SHELL_OK(avatar_.setTransform(worldFromAvatar()));
    if (options_.clip) {
        DPL_SHELL_OK(avatar_.setPoseFromClip(*options_.clip, frame.timeS));
    } else {
        DPL_SHELL_OK(avatar_.setPose(rest_));
    }
    return puppet_.pose(xr::moved(xr::inverse(body), user), options_.mirror, frame.timeS);
}

doppel::Status AvatarScene::draw(const xr::Frame& frame) {
    const VkCommandBuffer commands = frame.commands;
    std::optional<doppel::ContactShadow> shadow;
    if (options_.withAvatar) DPL_SHELL_OK(poseAvatar(frame));
    if (options_.withAvatar && !rest_.empty()) {
        DPL_SHELL_TRY(shadow, avatar_.contactShadow(0.0f));  // the floor of the stage space
    }
    for (uint32_t g = 0; g < frame.groupCount; ++g) {
        const xr::GroupFrame& group = frame.groups[g];
        shadows_->set(group.slot, {shadow ? &*shadow : nullptr, shadow ? 1u : 0u});
        for (uint32_t p = 0; p < images_->groups[g].passes; ++p)
            drawRoom(commands, images_->groups[g], group, p, passes_[g][p].drawing[group.colourImage[p]][group.depthImage[p]]);
    }
    if (!options_.withAvatar) return {};
    const DplAvatar avatars[] = {avatar_.handle()};
    for (uint32_t g = 0; g < frame.groupCount; ++g) {
        const xr::GroupFrame& group = frame.groups[g];
        DPL_SHELL_OK(doppel::status(
            dplVulkanPrepare(runtime_.context(), commands, group.slot, avatars, 1, group.cameras, group.views, group.depths)));
        for (uint32_t p = 0; p < images_->groups[g].passes; ++p) {
            VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
            begin.renderPass = composing_;
            begin.framebuffer = passes_[g][p].composing[group.colourImage[p]][group.depthImage[p]];
            begin.renderArea.extent = {images_->groups[g].widthPx, images_->groups[g].heightPx};
            vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
            doppel::Status composed = doppel::status(dplVulkanCompose(runtime_.context(), *composer_, commands, group.slot, p, 0, 0));
            if (composed)
                composed = doppel::status(
                    dplVulkanComposeDepth(runtime_.context(), *composer_, commands, group.slot, p, 0, 0, 0, platform::kRoomNearM));
            vkCmdEndRenderPass(commands);
            DPL_SHELL_OK(composed);
        }
    }
    return {};
}

}  // namespace dpl
