// SPDX-License-Identifier: Apache-2.0
// The images of a frame and the three passes that fill them:
//
//   room       clears and draws colour (linear, RGBA16F, four samples) and depth (reversed)
//   composing  loads the colour, takes the avatars, resolves the samples
//   finishing  writes the picture (RGBA8, display values), with the panels on top
//
// All frames in flight share the images; the passes' dependencies keep them in order on one queue.
#pragma once

#include <memory>

#include "platform/common/device.h"

namespace dpl::platform {

constexpr VkFormat kLightFormat = VK_FORMAT_R16G16B16A16_SFLOAT, kPictureFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kCanvasSamples = 4;

class Canvas {
public:
    /** Makes passes and pipelines. The device must live longer. */
    static Result<std::unique_ptr<Canvas>> create(Device& device);
    ~Canvas();
    Canvas(const Canvas&) = delete;
    Canvas& operator=(const Canvas&) = delete;

    /** Makes the images anew if the size differs. Waits for the queue then. After an error there are no images. */
    Status resize(VkExtent2D size);
    VkExtent2D size() const { return size_; }

    VkRenderPass roomPass() const { return room_; }
    VkRenderPass composingPass() const { return composing_; }
    VkRenderPass finishingPass() const { return finishing_; }

    void beginRoom(VkCommandBuffer commands) const;
    void beginComposing(VkCommandBuffer commands) const;
    /** Begins the pass and draws the light as display values. */
    void beginFinishing(VkCommandBuffer commands) const;

    /** After the room's pass it is visible to compute shaders, in DEPTH_STENCIL_READ_ONLY_OPTIMAL. */
    VkImageView depth() const { return depthImage_.view; }
    /** After the finishing pass in TRANSFER_SRC_OPTIMAL, visible to copies. */
    VkImage picture() const { return picture_.image; }

private:
    explicit Canvas(Device& device) : device_(device) {}
    Status makePasses();
    Status makeFinishing();
    Status makeImages();
    void destroyImages();
    void begin(VkCommandBuffer commands, VkRenderPass pass, VkFramebuffer framebuffer) const;

    Device& device_;
    VkExtent2D size_{};
    VkRenderPass room_ = VK_NULL_HANDLE, composing_ = VK_NULL_HANDLE, finishing_ = VK_NULL_HANDLE;
    Image light_, depthImage_, resolved_, picture_;
    VkFramebuffer roomFrame_ = VK_NULL_HANDLE, composingFrame_ = VK_NULL_HANDLE, finishingFrame_ = VK_NULL_HANDLE;
    VkSampler sampler_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace dpl::platform
