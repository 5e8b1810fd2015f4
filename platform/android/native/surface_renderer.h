// SPDX-License-Identifier: Apache-2.0
// Draws avatars into the window of an Android view: a Vulkan device with a Doppel context, which live as long as the view, and what belongs
// to one window (screen.h), which comes and goes.
//
//   window      lost ──► frames are not drawn, loads wait ──► a new one: drawing goes on, avatars were never unloaded
//   surface     lost or of another size in mid-frame ──► the next frame makes it anew
//   device      lost ──► the next frame opens another device and moves the avatars there (dplRebuildVulkan)
//
// Any thread; calls wait for one another, so once setWindow has returned, no frame uses the earlier window. A call waits for the GPU or
// the display at most kMostWaitNs at a time.
#pragma once

#include <doppel/doppel_vulkan.h>

#include <doppel/doppel.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "platform/android/native/window_surface.h"
#include "platform/common/device.h"

namespace dpl::android {

class Screen;

constexpr uint64_t kMostWaitNs = 1'000'000'000;

/** How a frame ended. The numbers are those of Outcome in Outcome.kt. */
enum class Outcome : int {
    Shown = 0,
    NoWindow = 1,     // there is no window, or its size is 0
    Skipped = 2,      // the display gave no image, or the GPU did not end an earlier frame, within kMostWaitNs
    SurfaceLost = 3,  // nothing was shown; the next frame tries again
    DeviceLost = 4,   // nothing was shown; the next frame opens another device
};

struct FrameRequest {
    std::span<const DplAvatar> avatars;  // may be empty
    DplCamera camera{};                  // of the window's size, or nearly: another size is fitted
    float background[3] = {0, 0, 0};     // display-referred, 0 to 1
    bool shadows = false;                // contact shadows of the avatars, over the background
};

class SurfaceRenderer {
public:
    /** info: as for dplCreateVulkanContext; may be NULL. validation: with the validation layer, see complaints(). */
    static doppel::Result<std::shared_ptr<SurfaceRenderer>> create(const DplContextInfo* info, bool validation);
    /** Destroys the context. */
    ~SurfaceRenderer();
    SurfaceRenderer(const SurfaceRenderer&) = delete;
    SurfaceRenderer& operator=(const SurfaceRenderer&) = delete;

    /** Lives as long as the renderer. */
    DplContext context() const { return context_; }
    std::string deviceName() const;

    /** Shows the next frames in this window; empty: in none. size: of its pixels. */
    void setWindow(Window window, VkExtent2D size);
    /** Draws and shows one frame. An error says why the avatars, or anything, could not be drawn; the next frame tries again. */
    doppel::Result<Outcome> draw(const FrameRequest& request);

    /** What the validation layer said so far. */
    std::vector<std::string> complaints() const;

private:
    SurfaceRenderer() = default;
    doppel::Result<std::unique_ptr<platform::Device>> openDevice() const;
    doppel::Status rebuild();
    doppel::Status makeScreen();
    /** What became of a frame that `error` has ended. Drops the screen, and with it what the frame had acquired. */
    doppel::Result<Outcome> broken(const doppel::Error& error);

    bool validation_ = false;
    mutable std::mutex mutex_;
    std::unique_ptr<platform::Device> device_;
    DplContext context_ = nullptr;
    Window window_;
    VkExtent2D windowPx_{};
    std::unique_ptr<Screen> screen_;
    bool deviceLost_ = false;
    std::vector<std::string> earlierComplaints_;  // of devices that were lost
};

}  // namespace dpl::android
