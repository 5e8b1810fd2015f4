// SPDX-License-Identifier: Apache-2.0
// The program's scene and its passes: a room drawn into an HDR target of four samples with a reversed depth buffer; then a second pass that
// loads both, in which the avatars are composed with their depth, then glass is drawn, and the colour is resolved.
#pragma once

#include <doppel/doppel.h>

#include <vector>

#include "device.h"

constexpr VkFormat kColourFormat = VK_FORMAT_R16G16B16A16_SFLOAT, kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr uint32_t kSamples = 4;
constexpr float kNearM = 0.1f;
constexpr float kGlass[4] = {0.05f, 0.2f, 0.16f, 0.5f};  // linear, premultiplied

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
    /** Draws a pane of glass over what the composing pass holds. What is nearer in the depth buffer hides it. */
    void drawGlass(VkCommandBuffer commands, const Target& target, const DplCamera& camera) const;
    /** `resolved` is in TRANSFER_SRC_OPTIMAL afterwards. */
    void endComposing(VkCommandBuffer commands) const;
    VkRenderPass composingPass() const { return composing_; }

private:
    void makePasses();
    VkPipeline makePipeline(bool glass) const;
    void begin(VkCommandBuffer commands, const Target& target, const DplCamera& camera, VkPipeline pipeline) const;

    const Device& device_;
    VkRenderPass drawing_ = VK_NULL_HANDLE, composing_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline room_ = VK_NULL_HANDLE, glass_ = VK_NULL_HANDLE;
};

/** View z of the room at a pixel, of the farthest of its four samples, as the depth buffer holds it; 0: nothing. */
float roomDepthM(const DplCamera& camera, uint32_t x, uint32_t y);

/** The number of samples of a pixel in which the glass shows. nearestM: view z of what else hides it; 0: nothing. */
int glassSamples(const DplCamera& camera, uint32_t x, uint32_t y, float nearestM);
