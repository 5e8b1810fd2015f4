// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>

#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {
namespace {

constexpr uint64_t kStagingBytes = 8u << 20;

}  // namespace

Result<uint32_t> VulkanBackend::memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted, VkMemoryPropertyFlags preferred) const {
    const VkPhysicalDeviceMemoryProperties& memory = device_->memory;
    for (VkMemoryPropertyFlags flags : {wanted | preferred, wanted})
        for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
            if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & flags) == flags) return i;
    return fail(Code::Device, "the device has no memory type with the Vulkan property flags {}", wanted);
}

Status VulkanBackend::makeBuffer(Buffer& b) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = (b.desc.bytes + 15) / 16 * 16;
    info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (b.desc.memory == BufferMemory::Device) info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    if (b.desc.memory == BufferMemory::Upload) info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
    if (device_->info.texels && b.desc.memory != BufferMemory::Readback) info.usage |= VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT;
    DPL_VK_MAKE(b.buffer, vk_.vkCreateBuffer(device_->device, &info, device_->allocator, &b.buffer));
    VkMemoryRequirements needs{};
    vk_.vkGetBufferMemoryRequirements(device_->device, b.buffer, &needs);
    VkMemoryPropertyFlags wanted = 0, preferred = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    if (b.desc.memory != BufferMemory::Device) wanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    if (b.desc.memory == BufferMemory::Readback) preferred = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    DPL_TRY(allocation.memoryTypeIndex, memoryType(needs.memoryTypeBits, wanted, preferred));
    if (VkResult result = vk_.vkAllocateMemory(device_->device, &allocation, device_->allocator, &b.memory); result != VK_SUCCESS) {
        b.memory = VK_NULL_HANDLE;
        const Error error = failVk("vkAllocateMemory", result);
        return fail(error.code, "{} bytes for {}: {}", needs.size, b.desc.label, error.message);
    }
    b.allocatedBytes = needs.size;
    DPL_VK(vk_.vkBindBufferMemory(device_->device, b.buffer, b.memory, 0));
    if (wanted) {
        void* mapped = nullptr;
        DPL_VK(vk_.vkMapMemory(device_->device, b.memory, 0, VK_WHOLE_SIZE, 0, &mapped));
        b.mapped = static_cast<std::byte*>(mapped);
    }
    return {};
}

void VulkanBackend::freeBuffer(Buffer& b) {
    for (VkBufferView view : b.texels) vk_.vkDestroyBufferView(device_->device, view, device_->allocator);
    vk_.vkDestroyBuffer(device_->device, b.buffer, device_->allocator);
    vk_.vkFreeMemory(device_->device, b.memory, device_->allocator);
    b = {};
}

Result<BufferId> VulkanBackend::createBuffer(const BufferDesc& desc) {
    if (desc.bytes == 0) return fail(Code::InvalidArgument, "buffer {} has no bytes", desc.label);
    Buffer b;
    b.desc = desc;
    if (auto status = desc.memory == BufferMemory::Lent ? Status() : makeBuffer(b); !status) {
        freeBuffer(b);
        return status.error();
    }
    b.born = encoded();
    const BufferId id{newId()};
    buffers_.emplace(id.value, std::move(b));
    return id;
}

void VulkanBackend::destroyBuffer(BufferId id) {
    const auto it = buffers_.find(id.value);
    if (it == buffers_.end()) return;
    dropCopies(id);
    retire(std::move(it->second), it->second.born);
    buffers_.erase(it);
}

Status VulkanBackend::write(BufferId id, uint64_t offset, std::span<const std::byte> bytes) {
    const auto it = buffers_.find(id.value);
    if (it == buffers_.end() || offset % 4 || offset > it->second.desc.bytes || bytes.size() > it->second.desc.bytes - offset)
        return fail(Code::InvalidArgument, "a write of {} bytes at {} does not fit the buffer", bytes.size(), offset);
    Buffer staging;
    staging.desc = {"staging", std::min<uint64_t>(std::max<uint64_t>(bytes.size(), 16), kStagingBytes), BufferMemory::Upload};
    Status status = makeBuffer(staging);
    for (size_t done = 0; status && done < bytes.size();) {
        const size_t part = std::min<size_t>(bytes.size() - done, staging.desc.bytes);
        std::memcpy(staging.mapped, bytes.data() + done, part);
        VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
        VkResult result = vk_.vkBeginCommandBuffer(uploadCommands_, &begin);
        const VkBufferCopy region{0, offset + done, part};
        if (result == VK_SUCCESS) vk_.vkCmdCopyBuffer(uploadCommands_, staging.buffer, it->second.buffer, 1, &region);
        if (result == VK_SUCCESS) result = vk_.vkEndCommandBuffer(uploadCommands_);
        status =
            result == VK_SUCCESS ? submitAndWait(uploadCommands_) : Status(failVk("vkBeginCommandBuffer or vkEndCommandBuffer", result));
        done += part;
    }
    freeBuffer(staging);
    if (status) it->second.written = true;
    return status;
}

std::span<std::byte> VulkanBackend::mapped(BufferId id) {
    const auto it = buffers_.find(id.value);
    if (it == buffers_.end() || !it->second.mapped) return {};
    return {it->second.mapped, size_t(it->second.desc.bytes)};
}

Status VulkanBackend::makeImage(Image& image, VkFormat format, const Target& target, VkImageUsageFlags usage, uint32_t samples) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {target.extent.width, target.extent.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = target.desc.multiview ? target.desc.views : 1;
    info.samples = VkSampleCountFlagBits(samples);
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage =
        usage | (samples > 1 ? VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT : VK_IMAGE_USAGE_TRANSFER_SRC_BIT);  // samples are only averaged
    DPL_VK_MAKE(image.image, vk_.vkCreateImage(device_->device, &info, device_->allocator, &image.image));
    VkMemoryRequirements needs{};
    vk_.vkGetImageMemoryRequirements(device_->device, image.image, &needs);
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    // Tile-based GPUs offer transient images a memory type that is never allocated, because the image never leaves the chip.
    const auto onChip = memoryType(needs.memoryTypeBits, VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (onChip)
        allocation.memoryTypeIndex = *onChip;
    else {
        DPL_TRY(allocation.memoryTypeIndex, memoryType(needs.memoryTypeBits, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT));
    }
    DPL_VK_MAKE(image.memory, vk_.vkAllocateMemory(device_->device, &allocation, device_->allocator, &image.memory));
    image.allocatedBytes = onChip ? 0 : needs.size;
    DPL_VK(vk_.vkBindImageMemory(device_->device, image.image, image.memory, 0));
    if (!(usage & VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT)) return {};  // images that are only copied need no view
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image.image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
    view.format = format;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, info.arrayLayers};
    DPL_VK_MAKE(image.view, vk_.vkCreateImageView(device_->device, &view, device_->allocator, &image.view));
    return {};
}

void VulkanBackend::freeImage(Image& image) {
    vk_.vkDestroyImageView(device_->device, image.view, device_->allocator);
    vk_.vkDestroyImage(device_->device, image.image, device_->allocator);
    vk_.vkFreeMemory(device_->device, image.memory, device_->allocator);
    image = {};
}

Status VulkanBackend::makeSurface(Surface& s, const Target& t) {
    constexpr VkImageUsageFlags kDrawn = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    const VkImageUsageFlags read = kDrawn | (t.desc.sampled ? VK_IMAGE_USAGE_SAMPLED_BIT : 0);
    DPL_RETURN_IF_ERROR(makeImage(s.colour, kColourFormat, t, read));
    if (!t.desc.sampled) {
        DPL_RETURN_IF_ERROR(makeImage(s.rounded, VK_FORMAT_R8G8B8A8_UNORM, t, VK_IMAGE_USAGE_TRANSFER_DST_BIT));
    }
    if (t.desc.depth) {
        DPL_RETURN_IF_ERROR(makeImage(s.depth, device_->depthSumFormat, t, read));
    }
    std::vector<VkImageView> views;  // in the order of the attachments in renderPass()
    if (t.desc.samples > 1) {
        DPL_RETURN_IF_ERROR(makeImage(s.colourSamples, kColourFormat, t, kDrawn, t.desc.samples));
        if (t.desc.depth) {
            DPL_RETURN_IF_ERROR(makeImage(s.depthSamples, device_->depthSumFormat, t, kDrawn, t.desc.samples));
        }
        views.push_back(s.colourSamples.view);
        if (t.desc.depth) views.push_back(s.depthSamples.view);
    }
    views.push_back(s.colour.view);
    if (t.desc.depth) views.push_back(s.depth.view);
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    DPL_TRY(info.renderPass, renderPass(t.desc));
    info.attachmentCount = uint32_t(views.size());
    info.pAttachments = views.data();
    info.width = t.extent.width;
    info.height = t.extent.height;
    info.layers = 1;  // required with multiview, where the view mask selects the layers
    DPL_VK_MAKE(s.framebuffer, vk_.vkCreateFramebuffer(device_->device, &info, device_->allocator, &s.framebuffer));
    return {};
}

void VulkanBackend::freeSurface(Surface& s) {
    vk_.vkDestroyFramebuffer(device_->device, s.framebuffer, device_->allocator);
    for (Image* image : {&s.colour, &s.depth, &s.rounded, &s.colourSamples, &s.depthSamples}) freeImage(*image);
}

Status VulkanBackend::makeTarget(Target& t) {
    const uint32_t limit = device_->info.maxTargetPx;
    if (t.desc.widthPx == 0 || t.desc.heightPx == 0 || t.desc.widthPx > limit || t.desc.heightPx > limit)
        return fail(Code::Unsupported, "a picture of {} x {} px is not possible; {} draws 1 to {} px a side", t.desc.widthPx,
                    t.desc.heightPx, device_->info.name, limit);
    if (t.desc.samples != 1 && (!device_->info.fourSamples || t.desc.samples != 4))
        return fail(Code::Unsupported, "{} samples a pixel are not possible on {}", t.desc.samples, device_->info.name);
    t.extent = {t.desc.widthPx, t.desc.heightPx};
    t.surfaces.resize(t.desc.multiview ? 1 : t.desc.views);
    for (Surface& surface : t.surfaces) {
        DPL_RETURN_IF_ERROR(makeSurface(surface, t));
    }
    return {};
}

void VulkanBackend::freeTarget(Target& t) {
    for (Surface& surface : t.surfaces) freeSurface(surface);
}

Result<TargetId> VulkanBackend::createTarget(const TargetDesc& desc) {
    Target t;
    t.desc = desc;
    if (auto status = makeTarget(t); !status) {
        freeTarget(t);
        return status.error();
    }
    t.born = encoded();
    const TargetId id{newId()};
    targets_.emplace(id.value, std::move(t));
    return id;
}

void VulkanBackend::destroyTarget(TargetId id) {
    const auto it = targets_.find(id.value);
    if (it == targets_.end()) return;
    retire(std::move(it->second), it->second.born);
    targets_.erase(it);
}

uint64_t VulkanBackend::residentBytes() const {
    const auto bytesOf = [](const Target& t) {
        uint64_t bytes = 0;
        for (const Surface& s : t.surfaces)
            bytes += s.colour.allocatedBytes + s.depth.allocatedBytes + s.rounded.allocatedBytes + s.colourSamples.allocatedBytes +
                     s.depthSamples.allocatedBytes;
        return bytes;
    };
    uint64_t bytes = 0;
    for (const auto& [id, b] : buffers_) bytes += b.allocatedBytes;
    for (const auto& [id, t] : targets_) bytes += bytesOf(t);
    retired_.forEach([&](const Retirable& object) {
        if (const auto* buffer = std::get_if<Buffer>(&object)) bytes += buffer->allocatedBytes;
        if (const auto* target = std::get_if<Target>(&object)) bytes += bytesOf(*target);
    });
    return bytes;
}

Result<VkBufferView> VulkanBackend::texels(Buffer& b, uint32_t words) {
    VkBufferView& view = b.texels[words / 2];
    if (view) return view;
    VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    info.buffer = b.buffer;
    info.format = words == 1 ? VK_FORMAT_R32_UINT : words == 2 ? VK_FORMAT_R32G32_UINT : VK_FORMAT_R32G32B32A32_UINT;
    info.range = VK_WHOLE_SIZE;
    DPL_VK_MAKE(view, vk_.vkCreateBufferView(device_->device, &info, device_->allocator, &view));
    return view;
}

const BufferDesc* VulkanBackend::buffer(BufferId id) const {
    const auto it = buffers_.find(id.value);
    return it == buffers_.end() ? nullptr : &it->second.desc;
}
const TargetDesc* VulkanBackend::target(TargetId id) const {
    const auto it = targets_.find(id.value);
    return it == targets_.end() ? nullptr : &it->second.desc;
}
const Shader* VulkanBackend::shader(PipelineId id) const {
    return id.value == 0 || id.value > pipelines_.size() ? nullptr : pipelines_[id.value - 1].shader;
}
const Shader* VulkanBackend::fragment(PipelineId id) const {
    return id.value == 0 || id.value > pipelines_.size() ? nullptr : pipelines_[id.value - 1].fragment;
}
bool VulkanBackend::written(BufferId id) const {
    return buffers_.at(id.value).written;
}
bool VulkanBackend::drawn(TargetId id) const {
    return targets_.at(id.value).drawn;
}

}  // namespace dpl::vk
