// SPDX-License-Identifier: Apache-2.0
// The command buffers of the frames in flight, their fences, and the slots of Doppel that each uses. Internal to this room.
//
//   frame 0 ─► commands 0, one slot a group ─► fence 0
//   frame 1 ─► commands 1 ...                            a frame waits for the fences of those who had its commands and slots before
#pragma once

#include "platform/openxr/calls.h"
#include "platform/openxr/scene.h"

namespace dpl::xr {

class FrameCommands {
public:
    explicit FrameCommands(const Runtime& runtime) : runtime_(runtime) {}
    /** All frames must have finished: waitForAll(). */
    ~FrameCommands();
    FrameCommands(const FrameCommands&) = delete;
    FrameCommands& operator=(const FrameCommands&) = delete;

    Status make();
    /** Waits until the frame's resources are free, begins its command buffer, and writes `commands` and the slot of each group. */
    Status begin(Frame& frame);
    Status submit();
    Status waitForAll();

private:
    Status wait(const VkFence* fences, uint32_t count) const;

    const Runtime& runtime_;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_[DPL_VULKAN_SLOTS]{};
    VkFence fences_[DPL_VULKAN_SLOTS]{};
    uint32_t userOfSlot_[DPL_VULKAN_SLOTS]{};  // index of the commands that used the slot last
    uint32_t current_ = 0, nextSlot_ = 0;
    bool fenceIsDead_ = false;  // a submission failed, so nothing signals its fence
};

}  // namespace dpl::xr
