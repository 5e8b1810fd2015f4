// SPDX-License-Identifier: Apache-2.0
// The program's scene and its passes: a room drawn into an HDR target of four samples with a reversed depth buffer; then a second pass that
// loads the colour, in which the avatars are composed, and resolves it.
#pragma once

#include <doppel/doppel.h>

#include <vector>

#include "device.h"

constexpr VkFormat kColourFormat = VK_FORMAT_R16G16B16A16_SFLOAT, kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr uint32_t kSamples = 4;
constexpr float kNearM = 0.1f;

/** Images of one size. */
struct Target {
    VkExtent2D size{};
    Image colour, depth, resolved;
    VkFramebuffer drawing = VK_NULL_HANDLE, composing = VK_NULL_HANDLE;
};

class Room {
public:
    explicit Room(const Device& device);
    ~Room();
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;

    Target makeTarget(VkExtent2D size) const;
    void destroy(Target& target) const;

    /** Draws the room. Afterwards colour is in COLOR_ATTACHMENT_OPTIMAL, depth in DEPTH_STENCIL_READ_ONLY_OPTIMAL and visible to compute.
     */
    void draw(VkCommandBuffer commands, const Target& target, const DplCamera& camera) const;
    void beginComposing(VkCommandBuffer commands, const Target& target) const;
    /** `resolved` is in TRANSFER_SRC_OPTIMAL afterwards. */
    void endComposing(VkCommandBuffer commands) const;
    VkRenderPass composingPass() const { return composing_; }

private:
    void makePasses();
    void makePipeline();

    const Device& device_;
    VkRenderPass drawing_ = VK_NULL_HANDLE, composing_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
};

/** View z of the room at a pixel, of the farthest of its four samples, as the depth buffer holds it; 0: nothing. */
float roomDepthM(const DplCamera& camera, uint32_t x, uint32_t y);
