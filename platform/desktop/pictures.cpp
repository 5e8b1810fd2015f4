// SPDX-License-Identifier: Apache-2.0
#include "platform/desktop/pictures.h"

#include <cstring>
#include <utility>

#include "picture_frag.h"
#include "picture_vert.h"

namespace dpl::platform {
namespace {

struct PicturePush {   // as in picture.vert and picture.frag
    float corners[4];  // left, top, right, bottom in clip space
    float part[4];     // the same of the picture, 0 to 1
    float opacity;
    float padding[3];
};

/** Brings an image from one layout and use into the next. */
struct Change {
    VkImageLayout before, after;
    VkPipelineStageFlags fromStage, toStage;
    VkAccessFlags fromAccess, toAccess;
};
constexpr Change kIntoCopy{
    VK_IMAGE_LAYOUT_UNDEFINED,   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0,
    VK_ACCESS_TRANSFER_WRITE_BIT};
constexpr Change kIntoShader{VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                             VK_PIPELINE_STAGE_TRANSFER_BIT,       VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                             VK_ACCESS_TRANSFER_WRITE_BIT,         VK_ACCESS_SHADER_READ_BIT};

void bring(VkCommandBuffer commands, VkImage image, const Change& change) {
    VkImageMemoryBarrier b{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    b.srcAccessMask = change.fromAccess, b.dstAccessMask = change.toAccess;
    b.oldLayout = change.before, b.newLayout = change.after;
    b.srcQueueFamilyIndex = b.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    b.image = image;
    b.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdPipelineBarrier(commands, change.fromStage, change.toStage, 0, 0, nullptr, 0, nullptr, 1, &b);
}

}  // namespace

Result<std::unique_ptr<Pictures>> Pictures::create(const VulkanHandles& on, VkRenderPass pass) {
    std::unique_ptr<Pictures> made(new Pictures(on));
    DPL_SHELL_OK(made->make(pass));
    return made;
}

Status Pictures::make(VkRenderPass pass) {
    const VkDevice device = on_.device;
    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler.magFilter = sampler.minFilter = VK_FILTER_LINEAR;
    sampler.addressModeU = sampler.addressModeV = sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    DPL_VK_MAKE(sampler_, vkCreateSampler, device, sampler);
    const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo setLayout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    setLayout.bindingCount = 1;
    setLayout.pBindings = &binding;
    DPL_VK_MAKE(setLayout_, vkCreateDescriptorSetLayout, device, setLayout);
    const VkDescriptorPoolSize poolSize{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2 * kMostPictures};  // shown, and retired
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
    pool.maxSets = 2 * kMostPictures;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &poolSize;
    DPL_VK_MAKE(pool_, vkCreateDescriptorPool, device, pool);
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(PicturePush)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &setLayout_;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    DPL_VK_MAKE(layout_, vkCreatePipelineLayout, device, layout);
    TriangleDrawing drawing;
    drawing.layout = layout_, drawing.pass = pass;
    drawing.vertexShader = picture_vert, drawing.fragmentShader = picture_frag;
    drawing.over = true;
    DPL_SHELL_TRY(pipeline_, makePipeline(device, drawing));
    return {};
}

Pictures::~Pictures() {
    for (auto& [id, held] : held_) destroy(held);
    for (Retired& retired : retired_) destroy(retired.held);
    for (auto& buffers : copied_)
        for (HostBuffer& buffer : buffers) destroyHostBuffer(on_, buffer);
    vkDestroyPipeline(on_.device, pipeline_, nullptr);
    vkDestroyPipelineLayout(on_.device, layout_, nullptr);
    vkDestroyDescriptorPool(on_.device, pool_, nullptr);
    vkDestroyDescriptorSetLayout(on_.device, setLayout_, nullptr);
    vkDestroySampler(on_.device, sampler_, nullptr);
}

void Pictures::destroy(Held& held) {
    if (held.set) vkFreeDescriptorSets(on_.device, pool_, 1, &held.set);
    destroyHostBuffer(on_, held.pixels);
    destroyImage(on_, held.image);
}

Status Pictures::fill(Held& held, std::span<const uint8_t> rgba) {
    DPL_SHELL_TRY(held.image, makeImage(on_, VK_FORMAT_R8G8B8A8_UNORM, held.size, 0, 1,
                                        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, VK_IMAGE_ASPECT_COLOR_BIT));
    DPL_SHELL_TRY(held.pixels, makeHostBuffer(on_, rgba.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT));
    std::memcpy(held.pixels.mapped, rgba.data(), rgba.size());
    VkDescriptorSetAllocateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    set.descriptorPool = pool_;
    set.descriptorSetCount = 1;
    set.pSetLayouts = &setLayout_;
    DPL_VK(vkAllocateDescriptorSets(on_.device, &set, &held.set));
    const VkDescriptorImageInfo image{sampler_, held.image.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = held.set;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    write.pImageInfo = &image;
    vkUpdateDescriptorSets(on_.device, 1, &write, 0, nullptr);
    return {};
}

Result<uint32_t> Pictures::add(std::span<const uint8_t> rgba, VkExtent2D size) {
    if (size.width == 0 || size.height == 0 || size.width > kLargestPx || size.height > kLargestPx ||
        rgba.size() != size_t(size.width) * size.height * 4)
        return Error{DPL_ERROR_INVALID_ARGUMENT, "a picture for the window must have 1 to 4096 columns and rows"};
    if (held_.size() + retired_.size() >= 2 * kMostPictures || held_.size() >= kMostPictures)
        return Error{DPL_ERROR_INVALID_ARGUMENT, "too many pictures in the window at once"};
    Held held;
    held.size = size;
    if (const Status filled = fill(held, rgba); !filled) {
        destroy(held);
        return filled.error();
    }
    held.rgba.assign(rgba.begin(), rgba.end());
    held_[next_] = std::move(held);
    return next_++;
}

Status Pictures::takeOver(const Pictures& lost) {
    for (const auto& [id, before] : lost.held_) {
        Held held;
        held.size = before.size;
        if (const Status filled = fill(held, before.rgba); !filled) {
            destroy(held);
            return filled;
        }
        held.rgba = before.rgba;
        held_[id] = std::move(held);
    }
    next_ = lost.next_;
    return {};
}

void Pictures::remove(uint32_t picture) {
    const auto found = held_.find(picture);
    if (found == held_.end()) return;
    found->second.rgba.clear();
    retired_.push_back({std::move(found->second), DPL_VULKAN_SLOTS + 1});
    held_.erase(found);
}

void Pictures::upload(VkCommandBuffer commands, uint32_t slot) {
    for (HostBuffer& buffer : copied_[slot]) destroyHostBuffer(on_, buffer);
    copied_[slot].clear();
    for (Retired& retired : retired_)
        if (--retired.framesLeft == 0) destroy(retired.held);
    std::erase_if(retired_, [](const Retired& retired) { return retired.framesLeft == 0; });
    for (auto& [id, held] : held_) {
        if (!held.pixels.buffer) continue;
        const VkImage image = held.image.image;
        bring(commands, image, kIntoCopy);
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.imageExtent = {held.size.width, held.size.height, 1};
        vkCmdCopyBufferToImage(commands, held.pixels.buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
        bring(commands, image, kIntoShader);
        copied_[slot].push_back(std::exchange(held.pixels, {}));
    }
}

void Pictures::record(VkCommandBuffer commands, VkExtent2D extent, std::span<const PlacedPicture> placed) const {
    if (placed.empty()) return;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    const VkViewport viewport{0, 0, float(extent.width), float(extent.height), 0, 1};
    const VkRect2D scissor{{0, 0}, extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    for (const PlacedPicture& p : placed) {
        const auto found = held_.find(p.picture);
        if (found == held_.end()) continue;
        const auto x = [&](float px) { return 2 * px / float(extent.width) - 1; };
        const auto y = [&](float px) { return 2 * px / float(extent.height) - 1; };
        const PicturePush push{{x(p.left), y(p.top), x(p.right), y(p.bottom)}, {p.fromX, p.fromY, p.toX, p.toY}, p.opacity, {}};
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &found->second.set, 0, nullptr);
        vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
        vkCmdDraw(commands, 6, 1, 0, 0);
    }
}

}  // namespace dpl::platform
