// SPDX-License-Identifier: Apache-2.0
// What a program draws in a session: a Scene gets a command buffer, images and cameras each frame. It draws its room with depth, lets
// Doppel prepare the avatars against that depth, and composes them.
//
// Views come in groups of one or two, because Doppel draws two views at once: a headset has one group, a headset with foveated insets two.
// World space is metres, y up, with y = 0 at the floor as far as the runtime knows it; the user looks along -z at the start.
#pragma once

#include <doppel/doppel_vulkan.h>

#include <doppel/doppel.hpp>
#include <vector>

#include "platform/openxr/user.h"

namespace dpl::xr {

constexpr uint32_t kMaxGroups = 2, kMaxViewsOfGroup = DPL_MAX_VIEWS, kMaxViews = kMaxGroups * kMaxViewsOfGroup;

/** How what is drawn meets what the user sees behind it. */
enum class Blend {
    Opaque,    // the picture covers everything
    Additive,  // light is added to the real surroundings: black shows them
    Alpha,     // premultiplied alpha: 0 shows the surroundings
};

/** Images of a group of views, the same ones as long as a session lives. The runtime owns the colour images. All views of images are
 *  VK_IMAGE_VIEW_TYPE_2D_ARRAY. Colour formats hold linear light (sRGB formats or RGBA16F). */
struct GroupImages {
    uint32_t widthPx = 0, heightPx = 0;
    uint32_t views = 0;   // 1 or 2
    uint32_t passes = 0;  // render passes to draw them: 1 with multiview (view mask 3), else as many as views
    std::vector<VkImageView> colour[kMaxViewsOfGroup], depth[kMaxViewsOfGroup];  // by pass, then by image; for framebuffers
};

/** What a session draws into. */
struct SessionImages {
    VkFormat colourFormat = VK_FORMAT_UNDEFINED, depthFormat = VK_FORMAT_UNDEFINED;
    bool multiview = false;
    Blend blend = Blend::Opaque;
    std::vector<GroupImages> groups;
};

/** A group in one frame. */
struct GroupFrame {
    uint32_t slot = 0;  // for dplVulkanPrepare
    uint32_t views = 0;
    uint32_t colourImage[kMaxViewsOfGroup]{}, depthImage[kMaxViewsOfGroup]{};  // by pass, indices into GroupImages
    DplCamera cameras[kMaxViewsOfGroup]{};
    DplVulkanSceneDepth depths[kMaxViewsOfGroup]{};  // for dplVulkanPrepare
};

struct Frame {
    uint64_t number = 0;  // of the drawn frames of the program, from 0
    double timeS = 0;     // when the picture will be seen, seconds since the first frame was; never runs backwards
    double periodS = 0;   // from one picture to the next; 0: the runtime did not say
    VkCommandBuffer commands = VK_NULL_HANDLE;
    uint32_t groupCount = 0;
    GroupFrame groups[kMaxGroups];
    User user;  // in world space, at the time of the picture
};

class Scene {
public:
    virtual ~Scene() = default;
    /** A session has its images: make framebuffers and pipelines. Called again for each new session. `images` lives until end(). */
    virtual doppel::Status begin(const SessionImages& images) = 0;
    /** The images go away. The GPU is idle. Follows each begin(), also one that failed. */
    virtual void end() = 0;
    /** Records one frame. It must not allocate, wait or submit.
     *  Colour images are found and left in COLOR_ATTACHMENT_OPTIMAL, with undefined contents. Depth images are found in any layout with
     *  undefined contents, and left in DEPTH_STENCIL_READ_ONLY_OPTIMAL, visible to the compute stage before dplVulkanPrepare. They hold
     *  reversed depth with an infinite far plane, SessionOptions::nearM / z. After an error the frame shows nothing and the session's
     *  frame() returns the error. */
    virtual doppel::Status draw(const Frame& frame) = 0;
};

}  // namespace dpl::xr
