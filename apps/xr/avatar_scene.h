// SPDX-License-Identifier: Apache-2.0
// The program's scene: a lit room with an avatar in it. Two render passes a view, or one pair for both eyes: the room with its depth; then
// the avatar, composed over it, with its depth.
#pragma once

#include <array>
#include <doppel/doppel.hpp>
#include <memory>
#include <optional>

#include "platform/common/floor_shadow.h"
#include "platform/common/room.h"
#include "platform/openxr/puppet.h"
#include "platform/openxr/runtime.h"
#include "platform/openxr/scene.h"
#include "platform/openxr/session.h"

namespace dpl {

struct SceneOptions {
    bool withRoom = true;  // where the picture is opaque; elsewhere the real room is seen
    bool withAvatar = true;
    std::optional<uint32_t> clip;  // none: the avatar stands in its rest pose
    bool withHands = true;         // the user's hands, where they are tracked, move the avatar's arms, wrists and fingers
    bool mirror = false;           // the avatar is the user's image in a mirror between them
};

class AvatarScene final : public xr::Scene {
public:
    /** Both must live longer. puppet: of that avatar. */
    AvatarScene(const xr::Runtime& runtime, doppel::Avatar& avatar, xr::Puppet puppet, const SceneOptions& options);
    ~AvatarScene() override;
    AvatarScene(const AvatarScene&) = delete;
    AvatarScene& operator=(const AvatarScene&) = delete;

    doppel::Status begin(const xr::SessionImages& images) override;
    void end() override;
    doppel::Status draw(const xr::Frame& frame) override;

    /** Where the avatar stands. */
    void place(const XrPosef& worldFromAvatar) { worldFromAvatar_ = worldFromAvatar; }
    const XrPosef& place() const { return worldFromAvatar_; }
    /** The same for Avatar::setTransform. */
    std::array<float, 12> worldFromAvatar() const;
    /** After a frame of the session: select puts the avatar where a controller points at the floor, and a stick turns it. What the session
     *  says of its origin is followed too. */
    void moveByControllers(const xr::Session& session);
    /** The user or the runtime has moved the origin of the world (Session::originMoved): things stay where they are in the room. */
    void originMoved(const XrPosef& oldFromNew);

private:
    struct Pass {                                                    // of a group's images
        std::vector<std::vector<VkFramebuffer>> drawing, composing;  // by colour image, then by depth image
    };

    doppel::Status poseAvatar(const xr::Frame& frame);
    doppel::Status makePasses();
    doppel::Status makeFramebuffers(const xr::GroupImages& group);
    void drawRoom(VkCommandBuffer commands, const xr::GroupImages& images, const xr::GroupFrame& group, uint32_t pass,
                  VkFramebuffer target) const;

    const xr::Runtime& runtime_;
    doppel::Avatar& avatar_;
    SceneOptions options_;
    XrPosef worldFromAvatar_{{0, 0, 0, 1}, {0, 0, -2}};  // two metres before the user, facing them
    xr::Puppet puppet_;
    xr::Stance stance_;                         // of the user, or of the user's image
    xr::Mirror mirror_{{0, 0, -1}, {0, 0, 1}};  // half-way to where the avatar stands at the start
    std::vector<float> rest_;                   // pose without a clip

    const xr::SessionImages* images_ = nullptr;
    VkRenderPass drawing_ = VK_NULL_HANDLE, composing_ = VK_NULL_HANDLE;
    std::unique_ptr<platform::Room> room_;
    std::unique_ptr<platform::FloorShadows> shadows_;
    std::optional<uint32_t> composer_;
    std::vector<VkFramebuffer> framebuffers_;  // all
    std::vector<std::vector<Pass>> passes_;    // by group
};

}  // namespace dpl
