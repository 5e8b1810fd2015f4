// SPDX-License-Identifier: Apache-2.0
#include "apps/xr/room.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "room_frag.h"
#include "room_vert.h"
#include "room_vert_multiview.h"

namespace dpl {
namespace {

constexpr uint32_t kBoxes = 6;  // as in room.vert

struct PushedView {
    float rows[12], lens[4];
};
struct Push {
    PushedView views[xr::kMaxViewsOfGroup];
};
static_assert(sizeof(Push) == 128, "the most that every device takes");

doppel::Status checked(VkResult result, const char* call) {
    if (result == VK_SUCCESS) return {};
    return doppel::Error{DPL_ERROR_DEVICE, std::string(call) + " failed with VkResult " + std::to_string(int(result))};
}

#define ROOM_OK(...) \
    if (doppel::Status roomStatus = (__VA_ARGS__); !roomStatus) return roomStatus.error()
#define ROOM_VK(call, ...) ROOM_OK(checked(call(__VA_ARGS__), #call))

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

PushedView pushed(const DplCamera& camera) {
    PushedView view;
    std::copy(std::begin(camera.viewFromWorld), std::end(camera.viewFromWorld), view.rows);
    const float width = float(camera.widthPx), height = float(camera.heightPx);
    view.lens[0] = 2 * camera.fx / width, view.lens[1] = 2 * camera.fy / height;
    view.lens[2] = 2 * camera.cx / width - 1, view.lens[3] = 2 * camera.cy / height - 1;
    return view;
}

}  // namespace

Room::Room(const xr::Runtime& runtime, doppel::Avatar& avatar, const RoomOptions& options)
    : runtime_(runtime), avatar_(avatar), options_(options) {}

Room::~Room() {
    end();
}

doppel::Status Room::begin(const xr::SessionImages& images) {
    images_ = &images;
    ROOM_OK(makePasses());
    ROOM_OK(makePipeline());
    DplVulkanPass pass{};
    pass.structSize = sizeof pass;
    pass.renderPass = composing_;
    pass.viewMask = images.multiview ? 3 : 0;
    pass.colourFormat = images.colourFormat;
    uint32_t composer = 0;
    ROOM_OK(doppel::status(dplCreateVulkanComposer(runtime_.context(), &pass, &composer)));
    composer_ = composer;
    for (const xr::GroupImages& group : images.groups) {
        std::vector<Pass>& made = passes_.emplace_back(group.passes);
        for (uint32_t p = 0; p < group.passes; ++p)
            for (VkImageView colour : group.colour[p]) {
                auto composing = makeFramebuffer(composing_, {colour}, group);
                if (!composing) return composing.error();
                made[p].composing.push_back(*composing);
                std::vector<VkFramebuffer>& drawing = made[p].drawing.emplace_back();
                for (VkImageView depth : group.depth[p]) {
                    auto both = makeFramebuffer(drawing_, {colour, depth}, group);
                    if (!both) return both.error();
                    drawing.push_back(*both);
                }
            }
    }
    return {};
}

void Room::end() {
    const VkDevice device = runtime_.device();
    for (VkFramebuffer framebuffer : framebuffers_) vkDestroyFramebuffer(device, framebuffer, nullptr);
    framebuffers_.clear(), passes_.clear();
    if (composer_) dplDestroyVulkanComposer(runtime_.context(), *composer_);
    composer_.reset();
    vkDestroyPipeline(device, pipeline_, nullptr);
    vkDestroyPipelineLayout(device, layout_, nullptr);
    vkDestroyRenderPass(device, drawing_, nullptr);
    vkDestroyRenderPass(device, composing_, nullptr);
    pipeline_ = VK_NULL_HANDLE, layout_ = VK_NULL_HANDLE, drawing_ = composing_ = VK_NULL_HANDLE;
    images_ = nullptr;
}

doppel::Result<VkFramebuffer> Room::makeFramebuffer(VkRenderPass pass, const std::vector<VkImageView>& views,
                                                    const xr::GroupImages& group) {
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    info.renderPass = pass;
    info.attachmentCount = uint32_t(views.size());
    info.pAttachments = views.data();
    info.width = group.widthPx, info.height = group.heightPx, info.layers = 1;
    VkFramebuffer made = VK_NULL_HANDLE;
    ROOM_VK(vkCreateFramebuffer, runtime_.device(), &info, nullptr, &made);
    framebuffers_.push_back(made);
    return made;
}

doppel::Status Room::makePasses() {
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
    ROOM_VK(vkCreateRenderPass, runtime_.device(), &info, nullptr, &drawing_);

    // The avatar: composed over the colour.
    const VkAttachmentDescription composed = attachment(images_->colourFormat, VK_ATTACHMENT_LOAD_OP_LOAD,
                                                        VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    const VkSubpassDependency before{VK_SUBPASS_EXTERNAL, 0, kColourStage, kColourStage, kColourAccess, kColourAccess, 0};
    subpass.pDepthStencilAttachment = nullptr;
    info.attachmentCount = 1;
    info.pAttachments = &composed;
    info.dependencyCount = 1;
    info.pDependencies = &before;
    ROOM_VK(vkCreateRenderPass, runtime_.device(), &info, nullptr, &composing_);
    return {};
}

doppel::Status Room::makePipeline() {
    const VkDevice device = runtime_.device();
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Push)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    ROOM_VK(vkCreatePipelineLayout, device, &layout, nullptr, &layout_);

    const VkSpecializationMapEntry entry{0, 0, sizeof(float)};
    const VkSpecializationInfo near{1, &entry, sizeof(float), &options_.nearM};
    VkPipelineShaderStageCreateInfo stages[2]{};
    const std::span<const uint32_t> vertex = images_->multiview ? std::span<const uint32_t>(room_vert_multiview) : room_vert;
    const std::span<const uint32_t> codes[2] = {vertex, room_frag};
    struct Modules {
        VkDevice device;
        VkShaderModule made[2]{};
        ~Modules() {
            for (VkShaderModule module : made) vkDestroyShaderModule(device, module, nullptr);
        }
    } modules{device};
    for (int i = 0; i < 2; ++i) {
        VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        info.codeSize = codes[i].size_bytes();
        info.pCode = codes[i].data();
        ROOM_VK(vkCreateShaderModule, device, &info, nullptr, &modules.made[i]);
        stages[i].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        stages[i].stage = i == 0 ? VK_SHADER_STAGE_VERTEX_BIT : VK_SHADER_STAGE_FRAGMENT_BIT;
        stages[i].module = modules.made[i];
        stages[i].pName = "main";
    }
    stages[0].pSpecializationInfo = &near;
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    VkPipelineColorBlendAttachmentState write{};
    write.colorWriteMask = 0xF;
    VkPipelineColorBlendStateCreateInfo colour{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    colour.attachmentCount = 1;
    colour.pAttachments = &write;
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = states;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &colour;
    info.pDynamicState = &dynamic;
    info.layout = layout_;
    info.renderPass = drawing_;
    ROOM_VK(vkCreateGraphicsPipelines, device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
    return {};
}

void Room::drawRoom(VkCommandBuffer commands, const xr::GroupImages& images, const xr::GroupFrame& group, uint32_t pass,
                    VkFramebuffer target) const {
    const bool shown = options_.withRoom && images_->blend == xr::Blend::Opaque;
    VkClearValue clear[2]{};
    if (shown) clear[0].color = {{0.05f, 0.06f, 0.09f, 1}};
    clear[1].depthStencil.depth = 0;  // infinitely far
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = drawing_;
    begin.framebuffer = target;
    begin.renderArea.extent = {images.widthPx, images.heightPx};
    begin.clearValueCount = 2;
    begin.pClearValues = clear;
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    if (shown) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
        const VkViewport viewport{0, 0, float(images.widthPx), float(images.heightPx), 0, 1};
        const VkRect2D scissor{{0, 0}, begin.renderArea.extent};
        vkCmdSetViewport(commands, 0, 1, &viewport);
        vkCmdSetScissor(commands, 0, 1, &scissor);
        Push push;
        for (uint32_t v = 0; v < xr::kMaxViewsOfGroup; ++v) push.views[v] = pushed(group.cameras[images_->multiview ? v : pass]);
        vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);
        vkCmdDraw(commands, 36, kBoxes, 0, 0);
    }
    vkCmdEndRenderPass(commands);
}

DplCamera Room::cameraOfAvatar(const DplCamera& camera) const {
    DplCamera moved = camera;
    XrVector3f columns[4] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, worldFromAvatar_.position};
    for (int i = 0; i < 3; ++i) columns[i] = xr::rotate(worldFromAvatar_.orientation, columns[i]);
    for (int row = 0; row < 3; ++row) {
        const float* m = camera.viewFromWorld + 4 * row;
        for (int column = 0; column < 4; ++column) {
            const XrVector3f& c = columns[column];
            moved.viewFromWorld[4 * row + column] = m[0] * c.x + m[1] * c.y + m[2] * c.z + (column == 3 ? m[3] : 0);
        }
    }
    return moved;
}

doppel::Status Room::draw(const xr::Frame& frame) {
    const VkCommandBuffer commands = frame.commands;
    for (uint32_t g = 0; g < frame.groupCount; ++g) {
        const xr::GroupFrame& group = frame.groups[g];
        for (uint32_t p = 0; p < images_->groups[g].passes; ++p)
            drawRoom(commands, images_->groups[g], group, p, passes_[g][p].drawing[group.colourImage[p]][group.depthImage[p]]);
    }
    if (!options_.withAvatar) return {};
    if (options_.clip) ROOM_OK(avatar_.setPoseFromClip(*options_.clip, frame.timeS));
    const DplAvatar avatars[] = {avatar_.handle()};
    for (uint32_t g = 0; g < frame.groupCount; ++g) {
        const xr::GroupFrame& group = frame.groups[g];
        DplCamera cameras[xr::kMaxViewsOfGroup];
        for (uint32_t v = 0; v < group.views; ++v) cameras[v] = cameraOfAvatar(group.cameras[v]);
        ROOM_OK(doppel::status(dplVulkanPrepare(runtime_.context(), commands, group.slot, avatars, 1, cameras, group.views, group.depths)));
        for (uint32_t p = 0; p < images_->groups[g].passes; ++p) {
            VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
            begin.renderPass = composing_;
            begin.framebuffer = passes_[g][p].composing[group.colourImage[p]];
            begin.renderArea.extent = {images_->groups[g].widthPx, images_->groups[g].heightPx};
            vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
            const doppel::Status composed = doppel::status(dplVulkanCompose(runtime_.context(), *composer_, commands, group.slot, p, 0, 0));
            vkCmdEndRenderPass(commands);
            ROOM_OK(composed);
        }
    }
    return {};
}

}  // namespace dpl
