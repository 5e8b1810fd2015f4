// SPDX-License-Identifier: Apache-2.0
// A window in which an app draws avatars: the frame loop over window, device, swapchain, room and Dear ImGui. All functions are called from
// the main thread, except where a comment says otherwise. An error is that of the window or the device: after it, destroy the shell. A lost
// device (DPL_ERROR_DEVICE) can be opened again instead:
//
//   shell->rebuild();  dplRebuildVulkan(context, &shell->deviceForDoppel());  composer = shell->makeComposer(context);
//   shell->forgetLostDevice();
//
//   auto shell = Shell::create({"title", 1280, 800});
//   // on a worker: context = dplCreateVulkanContext(&(*shell)->deviceForDoppel(), ...); composer = (*shell)->makeComposer(context);
//   while ((*shell)->beginFrame()) {
//       ImGui::Begin(...);
//       (*shell)->draw(contents);
//   }
#pragma once

#include <doppel/doppel_vulkan.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "platform/common/floor_shadow.h"
#include "platform/common/room.h"
#include "platform/desktop/pictures.h"

namespace dpl::platform {

struct ShellInfo {
    std::string title;
    uint32_t widthPx = 0, heightPx = 0;
    bool fixedPicture = false;                // pictures keep this size even if the window gets another one
    bool validation = false;                  // load the validation layer
    float scale = 0;                          // pixels for one of ImGui's coordinates; 0: what the screen has, or 1 for a fixed picture
    std::function<void(const char*)> onStep;  // told which step of the start is done; may be empty
};

struct FrameContents {
    DplCamera view{};               // sized as Shell::picturePx
    std::optional<RoomLight> room;  // nothing: black, and nothing is hidden
    DplContext context = nullptr;   // with what makeComposer returned for it; NULL: draw no avatars
    uint32_t composer = 0;
    std::vector<DplAvatar> avatars;              // may be empty
    std::vector<doppel::ContactShadow> shadows;  // on the floor of the room; at most kMaxStands
    std::vector<PlacedPicture> pictures;         // over the avatars, below the panels, one after the other
    bool panels = true;                          // draw what ImGui was told
    std::vector<uint8_t>* rgb = nullptr;         // receives the picture, three bytes a pixel; costs a wait
    bool rgbPanels = true;                       // that has the panels too
};

class Shell {
public:
    /** opensAgain: asked when the device is lost while it is opened, with the error; true: open it again, in the same window. Empty: never.
     */
    static Result<std::unique_ptr<Shell>> create(const ShellInfo& info, const std::function<bool(const Error&)>& opensAgain = {});
    /** Waits for the device. Destroy all contexts on the device first. */
    ~Shell();
    Shell(const Shell&) = delete;
    Shell& operator=(const Shell&) = delete;

    /** For dplCreateVulkanContext. Any thread. Valid as long as the shell. */
    DplVulkanDevice deviceForDoppel();
    /** Compiles what composes into this shell's pass; see dplCreateVulkanComposer. Any thread. */
    DplResult makeComposer(DplContext context, uint32_t* composer) const;
    const std::string& deviceName() const;

    /** Handles events and begins a frame of ImGui. False: the user has closed the window. */
    bool beginFrame();
    /** Size of the picture of this frame; 0 × 0 while the window is minimised. */
    VkExtent2D picturePx() const { return picturePx_; }
    /** Ends the frame that beginFrame began: draws and shows it, unless the window is minimised. Returns why the avatars could not be
     * drawn, or "". */
    Result<std::string> draw(const FrameContents& contents);
    /** Pictures that draw has shown. */
    uint64_t shown() const { return shown_; }

    /** A picture for FrameContents::pictures: display values with straight alpha, four bytes a pixel, top row first. Copies them; the next
     *  frame uploads them, and nothing waits. DPL_ERROR_INVALID_ARGUMENT: larger than 4096 pixels a side, or more than 16 pictures. */
    Result<uint32_t> addPicture(std::span<const uint8_t> rgba, uint32_t widthPx, uint32_t heightPx);
    /** Frames in flight may still show it. */
    void removePicture(uint32_t picture);

    /** Waits until no frame is in flight, then builds the room anew. */
    Status buildRoom(const RoomPlan& plan);
    /** Waits for the frames in flight, for example before avatars and contexts are destroyed. */
    Status waitIdle();
    void hideWindow();

    /** Opens a lost device anew, or another one that is better now. The window, what ImGui knows, the room and the pictures stay; a frame
     *  that was begun is over. Contexts are still on the lost device: move them with dplRebuildVulkan. No other thread may use the shell
     *  meanwhile. After an error only this function may be called, again, or the destructor. */
    Status rebuild();
    /** No context is on the lost device any more. */
    void forgetLostDevice();

    std::vector<std::string> takeDropped();
    /** GLFW_KEY_* of keys that no text field wanted. */
    std::vector<int> takeKeys();
    std::vector<std::string> complaints() const;

private:
    struct Parts;
    explicit Shell(const ShellInfo& info);
    Status makeParts();
    Status makeOnDevice();
    Status readPicture(const FrameContents& contents);

    const ShellInfo info_;
    std::unique_ptr<Parts> parts_;
    VkExtent2D picturePx_{};
    std::optional<RoomPlan> plan_;         // of the room
    std::vector<std::string> complaints_;  // about devices that are gone
    uint64_t frame_ = 0, shown_ = 0;
};

}  // namespace dpl::platform
