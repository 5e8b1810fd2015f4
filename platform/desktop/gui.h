// SPDX-License-Identifier: Apache-2.0
// Dear ImGui with Debian's GLFW and Vulkan backends. What differs between the versions of Debian 12, Debian 13 and Ubuntu is in gui.cpp.
#pragma once

#include <memory>

#include "platform/common/device.h"
#include "platform/desktop/window.h"

namespace dpl::platform {

class Gui {
public:
    /** At most one at a time; the window must outlive it. scale: pixels of the picture for one of ImGui's coordinates, from 0.5 to 4. */
    static std::unique_ptr<Gui> create(const Window& window, float scale);
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    /** Draws by this device from now on, which must outlive it or its leave(). pass: with one RGBA8 or BGRA8 attachment of display values
     *  and one sample. Uploads the font and waits for it. After an error call leave(). */
    Status enter(Device& device, VkRenderPass pass, uint32_t framesInFlight);
    /** Draws by no device any more; what ImGui knows stays, and a frame that was begun is over. Frames in flight have ended. */
    void leave();

    /** Between these two the app calls ImGui. size: of the picture, px. */
    void beginFrame(VkExtent2D size);
    void endFrame();
    /** Inside the pass. */
    Status record(VkCommandBuffer commands) const;

private:
    explicit Gui(float scale) : scale_(scale) {}

    Device* device_ = nullptr;  // NULL: it has entered none
    const float scale_;
    bool frameOpen_ = false;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
};

}  // namespace dpl::platform
