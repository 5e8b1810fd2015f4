// SPDX-License-Identifier: Apache-2.0
// The smallest scene that shows what matters: a wall in front of an avatar's right half, over a plain colour, with depth for both.
#pragma once

#include <deque>
#include <vector>

#include "platform/openxr/runtime.h"
#include "platform/openxr/scene.h"

namespace dpl::test {

constexpr float kNearM = 0.1f;                                                         // of the depth images
constexpr float kWallM = 2.5f;                                                         // view z of the wall
constexpr float kPlain[4] = {0.05f, 0.2f, 0.4f, 1}, kWall[4] = {0.5f, 0.4f, 0.1f, 1};  // linear light

/** The wall covers the columns from this one on. */
constexpr uint32_t wallFromPx(uint32_t widthPx) {
    return widthPx / 2 + 3;
}

class RoomScene : public xr::Scene {
public:
    /** avatars: must outlive the scene; may be empty. */
    RoomScene(xr::Runtime& runtime, std::vector<DplAvatar> avatars) : runtime_(runtime), avatars_(std::move(avatars)) {}
    ~RoomScene() override { destroyPasses(); }

    doppel::Status begin(const xr::SessionImages& images) override;
    void end() override;
    doppel::Status draw(const xr::Frame& frame) override;

    bool failNextBegin = false, failNextDraw = false;
    int begun = 0, ended = 0;
    VkFormat colourFormat = VK_FORMAT_UNDEFINED;
    bool multiview = false;
    xr::Blend blend = xr::Blend::Opaque;

private:
    struct Group {
        uint32_t widthPx, heightPx, passes;
        std::vector<VkFramebuffer> room[xr::kMaxViewsOfGroup],
            compose[xr::kMaxViewsOfGroup];  // by pass: colour image + depth image; colour
        size_t depthImages[xr::kMaxViewsOfGroup];
    };
    void destroyPasses();
    VkRenderPass makePass(bool withDepth, uint32_t viewMask) const;
    VkFramebuffer makeFramebuffer(VkRenderPass pass, std::span<const VkImageView> views, uint32_t widthPx, uint32_t heightPx) const;

    /** Passes and their composer for one kind of view. They outlive sessions, so that a sweep over many of them compiles once. */
    struct Passes {
        uint32_t viewMask = 0;
        VkRenderPass room = VK_NULL_HANDLE, compose = VK_NULL_HANDLE;
        uint32_t composer = 0;
    };
    doppel::Result<const Passes*> passesFor(uint32_t viewMask);

    xr::Runtime& runtime_;
    std::vector<DplAvatar> avatars_;
    std::deque<Passes> passes_;
    VkFormat passColour_ = VK_FORMAT_UNDEFINED, passDepth_ = VK_FORMAT_UNDEFINED;
    std::vector<Group> groups_;
    std::vector<const Passes*> groupPasses_;
    VkFormat depthFormat_ = VK_FORMAT_UNDEFINED;
};

}  // namespace dpl::test
