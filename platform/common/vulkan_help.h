// SPDX-License-Identifier: Apache-2.0
// Vulkan calls that every shell makes in the same way. What fails leaves nothing behind.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "platform/common/errors.h"

namespace dpl::platform {

/** A device with the physical device it was made from. Owns nothing. */
struct VulkanHandles {
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
};

/** Index of a memory type among the bits of `allowed` with all `wanted` flags. */
Result<uint32_t> memoryTypeOf(VkPhysicalDevice physical, uint32_t allowed, VkMemoryPropertyFlags wanted);

struct Image {
    VkImage image = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
};

/** A 2D image with one level in memory of its own. layers > 0: the view is a 2D array; 0: one layer, and the view is 2D. */
Result<Image> makeImage(const VulkanHandles& on, VkFormat format, VkExtent2D size, uint32_t layers, uint32_t samples,
                        VkImageUsageFlags usage, VkImageAspectFlags aspect);
void destroyImage(const VulkanHandles& on, Image& image);

/** A buffer that the CPU can read and write; it stays mapped, and its memory is coherent. */
struct HostBuffer {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    void* mapped = nullptr;
};
Result<HostBuffer> makeHostBuffer(const VulkanHandles& on, VkDeviceSize bytes, VkBufferUsageFlags usage);
void destroyHostBuffer(const VulkanHandles& on, HostBuffer& buffer);

Result<VkShaderModule> makeShaderModule(VkDevice device, std::span<const uint32_t> words);

/** One layer, without flags. The views are in the order of the pass's attachments. */
Result<VkFramebuffer> makeFramebuffer(VkDevice device, VkRenderPass pass, std::span<const VkImageView> views, VkExtent2D size);

/** How lists of triangles are drawn into one colour attachment, which they replace. Viewport and scissor are dynamic. */
struct TriangleDrawing {
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkRenderPass pass = VK_NULL_HANDLE;
    uint32_t subpass = 0, samples = 1;
    std::span<const uint32_t> vertexShader, fragmentShader;                                                 // SPIR-V, entry point "main"
    const VkSpecializationInfo* special = nullptr;                                                          // of the fragment shader
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};  // none: no vertex buffer
    bool frontOnly = false;            // leaves out triangles that are clockwise in the image
    std::optional<VkCompareOp> depth;  // compares with stored depth; what passes is written. None: no depth
    bool over = false;                 // blends by alpha over what is there, and writes no depth
};
Result<VkPipeline> makePipeline(VkDevice device, const TriangleDrawing& drawing);

}  // namespace dpl::platform
