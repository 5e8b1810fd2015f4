// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/capture.h"

#include <algorithm>
#include <cstring>

namespace dpl::xr {
namespace {

uint32_t pixelBytes(VkFormat colour) {
    return colour == VK_FORMAT_R16G16B16A16_SFLOAT ? 8 : 4;
}

/** Bytes of a pixel's depth when it is copied into a buffer. */
uint32_t depthBytes(VkFormat format) {
    return format == VK_FORMAT_D16_UNORM ? 2 : 4;
}

float depthOf(VkFormat format, const uint8_t* at) {
    if (format == VK_FORMAT_D16_UNORM) {
        uint16_t code;
        std::memcpy(&code, at, sizeof code);
        return float(code) / 65535;
    }
    if (format == VK_FORMAT_D24_UNORM_S8_UINT) {
        uint32_t code;
        std::memcpy(&code, at, sizeof code);
        return float(double(code & 0xFFFFFF) / 0xFFFFFF);
    }
    float value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

void barrier(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspects, uint32_t layer, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier b{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    b.srcAccessMask = b.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    b.oldLayout = from, b.newLayout = to;
    b.srcQueueFamilyIndex = b.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    b.image = image;
    b.subresourceRange = {aspects, 0, 1, layer, 1};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1,
                         &b);
}

}  // namespace

Status Capture::makeBuffer(VkDeviceSize bytes, Buffer& made) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    DPL_XR_OK(Calls::check(vkCreateBuffer(runtime_.device(), &info, nullptr, &made.buffer), "vkCreateBuffer"));
    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(runtime_.device(), made.buffer, &needs);
    const auto type = runtime_.memoryType(needs.memoryTypeBits, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    if (!type) return type.error();
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = *type;
    DPL_XR_OK(Calls::check(vkAllocateMemory(runtime_.device(), &allocation, nullptr, &made.memory), "vkAllocateMemory"));
    return Calls::check(vkBindBufferMemory(runtime_.device(), made.buffer, made.memory, 0), "vkBindBufferMemory");
}

void Capture::clear() {
    for (const Buffer& buffer : buffers_) {
        vkDestroyBuffer(runtime_.device(), buffer.buffer, nullptr);
        vkFreeMemory(runtime_.device(), buffer.memory, nullptr);
    }
    buffers_.clear();
}

Status Capture::begin(const SessionImages& images) {
    clear();
    for (const GroupImages& group : images.groups)
        for (uint32_t v = 0; v < group.views; ++v) {
            const VkDeviceSize pixels = VkDeviceSize(group.widthPx) * group.heightPx;
            Buffer& made = buffers_.emplace_back();
            made.colourBytes = pixels * pixelBytes(images.colourFormat);
            made.depthBytes = pixels * depthBytes(images.depthFormat);
            DPL_XR_OK(makeBuffer(made.colourBytes + made.depthBytes, made));
        }
    return {};
}

void Capture::record(VkCommandBuffer commands, const Images& images) const {
    size_t n = 0;
    for (uint32_t g = 0; g < images.shown().groups.size(); ++g) {
        const GroupImages& group = images.shown().groups[g];
        for (uint32_t v = 0; v < group.views; ++v) {
            const Buffer& to = buffers_[n++];
            const Images::Place colour = images.colourOf(g, v), depth = images.depthOf(g, v);
            const struct {
                Images::Place place;
                VkImageAspectFlags aspects, copied;
                VkImageLayout layout;
                VkDeviceSize offset;
            } copies[] = {
                {colour, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, 0},
                {depth, images.depthAspects(), VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL, to.colourBytes}};
            for (const auto& copy : copies) {
                const VkImage image = copy.place.image;
                const uint32_t layer = copy.place.layer;
                barrier(commands, image, copy.aspects, layer, copy.layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
                VkBufferImageCopy region{};
                region.bufferOffset = copy.offset;
                region.imageSubresource = {copy.copied, 0, layer, 1};
                region.imageExtent = {group.widthPx, group.heightPx, 1};
                vkCmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.buffer, 1, &region);
                barrier(commands, image, copy.aspects, layer, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, copy.layout);
            }
        }
    }
    VkMemoryBarrier toHost{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    toHost.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    toHost.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &toHost, 0, nullptr, 0, nullptr);
}

Status Capture::read(const SessionImages& images, float nearM, std::vector<CapturedView>& views) {
    views.clear();
    for (const GroupImages& group : images.groups)
        for (uint32_t v = 0; v < group.views; ++v) {
            const Buffer& from = buffers_[views.size()];
            CapturedView& view = views.emplace_back();
            view.widthPx = group.widthPx, view.heightPx = group.heightPx;
            view.format = images.colourFormat;
            void* mapped = nullptr;
            DPL_XR_OK(Calls::check(vkMapMemory(runtime_.device(), from.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory"));
            const auto* bytes = static_cast<const uint8_t*>(mapped);
            view.colour.assign(bytes, bytes + from.colourBytes);
            const uint32_t step = depthBytes(images.depthFormat);
            for (VkDeviceSize at = 0; at < from.depthBytes; at += step) {
                const float stored = depthOf(images.depthFormat, bytes + from.colourBytes + at);
                view.depthM.push_back(stored > 0 ? nearM / stored : 0);
            }
            vkUnmapMemory(runtime_.device(), from.memory);
        }
    clear();
    return {};
}

}  // namespace dpl::xr
