// SPDX-License-Identifier: Apache-2.0
// All images of a session: colour from the runtime; depth from the runtime if it takes depth layers, else of our own. Internal to this
// room.
//
//   group ─► array image, a layer for each view           (one swapchain)
//         └► an image for each view                       (a swapchain each), where arrays are refused or not wanted
#pragma once

#include "platform/openxr/display.h"
#include "platform/openxr/swapchain.h"

namespace dpl::xr {

class Images {
public:
    explicit Images(const Runtime& runtime) : runtime_(runtime) {}
    /** The GPU must have finished all frames. */
    ~Images();
    Images(const Images&) = delete;
    Images& operator=(const Images&) = delete;

    Status make(Calls& calls, XrSession session, const Display& display, const SessionOptions& options);

    /** False: a wait timed out. */
    Result<bool> acquire(Calls& calls);
    Status release(Calls& calls);
    /** Writes images and depths of the acquired images. */
    void describe(uint32_t group, float nearM, GroupFrame& frame) const;
    /** Records what brings depth images of the runtime into the layout in which it wants them back. */
    void giveDepthBack(VkCommandBuffer commands) const;

    struct Place {
        VkImage image = VK_NULL_HANDLE;
        uint32_t layer = 0;
    };
    Place colourOf(uint32_t group, uint32_t view) const;
    Place depthOf(uint32_t group, uint32_t view) const;
    XrSwapchainSubImage colourLayer(uint32_t group, uint32_t view) const { return layerOf(groups_[group].colour, group, view); }
    /** Only if hasDepthLayer(). */
    XrSwapchainSubImage depthLayer(uint32_t group, uint32_t view) const { return layerOf(groups_[group].depth, group, view); }
    bool hasDepthLayer() const { return !groups_.empty() && !groups_[0].depth.empty(); }
    VkImageAspectFlags depthAspects() const;  // of the depth format, stencil included
    const SessionImages& shown() const { return shown_; }
    SessionImages& shown() { return shown_; }

private:
    struct Group {
        std::vector<Swapchain> colour, depth;  // one, or one for each view. depth: none if ownDepth
        VkImage ownDepth = VK_NULL_HANDLE;     // a layer for each view
        VkDeviceMemory memory = VK_NULL_HANDLE;
        std::vector<VkImageView> sampledDepth[kMaxViewsOfGroup];  // by pass, then by image
        std::vector<VkImageView> views;                           // all that were made
    };
    using Chains = std::vector<std::vector<Swapchain>>;  // by group

    Result<Chains> makeChains(Calls& calls, XrSession session, const Display& display, bool array, VkFormat format,
                              XrSwapchainUsageFlags usage) const;
    Status makeColour(Calls& calls, XrSession session, const Display& display, const SessionOptions& options,
                      const std::vector<int64_t>& formats);
    Status makeDepth(Calls& calls, XrSession session, const Display& display, const SessionOptions& options,
                     const std::vector<int64_t>& formats);
    Status makeOwnDepth(uint32_t group);
    Status makeViews(uint32_t group);
    bool canDrawDepth(VkFormat format) const;
    Result<VkImageView> makeView(Group& group, VkImage image, VkFormat format, VkImageAspectFlags aspect, uint32_t layer, uint32_t layers);
    XrSwapchainSubImage layerOf(const std::vector<Swapchain>& chains, uint32_t group, uint32_t view) const;

    const Runtime& runtime_;
    std::vector<Group> groups_;
    bool array_ = false;
    SessionImages shown_;
};

}  // namespace dpl::xr
