// SPDX-License-Identifier: Apache-2.0
// Pictures of the app, laid flat over the avatars and below the panels.
//
//   auto id = pictures->add(rgba, 640, 480);            any time between frames; copies the pixels, waits for nothing
//   each frame:  pictures->upload(commands, slot);      before the passes
//                pictures->record(commands, extent, placed);      inside the finishing pass
#pragma once

#include <doppel/doppel_vulkan.h>

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "platform/common/vulkan_help.h"

namespace dpl::platform {

/** A picture, or a part of it, in the picture of a frame. */
struct PlacedPicture {
    uint32_t picture = 0;                            // of Shell::addPicture
    float left = 0, top = 0, right = 0, bottom = 0;  // pixels of the frame's picture
    float fromX = 0, fromY = 0, toX = 1, toY = 1;    // the part of it that is shown; 1: its whole width and height
    float opacity = 1;
};

class Pictures {
public:
    static constexpr uint32_t kMostPictures = 16, kLargestPx = 4096;

    /** pass: with one attachment of display values and one sample. The device must outlive it, and be idle when it goes. */
    static Result<std::unique_ptr<Pictures>> create(const VulkanHandles& on, VkRenderPass pass);
    ~Pictures();
    Pictures(const Pictures&) = delete;
    Pictures& operator=(const Pictures&) = delete;

    /** rgba: display values with straight alpha, top row first. DPL_ERROR_INVALID_ARGUMENT: too large, or too many. */
    Result<uint32_t> add(std::span<const uint8_t> rgba, VkExtent2D size);
    /** Shows the pictures of another device, under their ids. For one that shows none yet. */
    Status takeOver(const Pictures& lost);
    /** Frames may still show it; it goes when they are done. An id that is not known is ignored. */
    void remove(uint32_t picture);

    /** Records the copies of new pictures. Only when no submitted commands of the slot can still run. */
    void upload(VkCommandBuffer commands, uint32_t slot);
    /** Pictures that are not known are left out. */
    void record(VkCommandBuffer commands, VkExtent2D extent, std::span<const PlacedPicture> placed) const;

private:
    struct Held {
        Image image;
        HostBuffer pixels;  // until they are uploaded
        VkExtent2D size{};
        VkDescriptorSet set = VK_NULL_HANDLE;
        std::vector<uint8_t> rgba;  // for another device, if this one is lost
    };
    struct Retired {
        Held held;
        uint32_t framesLeft = 0;  // until no slot uses it any more
    };
    explicit Pictures(const VulkanHandles& on) : on_(on) {}
    Status make(VkRenderPass pass);
    Status fill(Held& held, std::span<const uint8_t> rgba);
    void destroy(Held& held);

    VulkanHandles on_;
    VkSampler sampler_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    std::map<uint32_t, Held> held_;
    std::vector<Retired> retired_;
    std::vector<HostBuffer> copied_[DPL_VULKAN_SLOTS];  // read by the commands of a slot
    uint32_t next_ = 1;
};

}  // namespace dpl::platform
