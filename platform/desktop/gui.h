// SPDX-License-Identifier: Apache-2.0
// Dear ImGui with Debian's GLFW and Vulkan backends. What differs between the versions of Debian 12, Debian 13 and Ubuntu is in gui.cpp.
#pragma once

#include <memory>

#include "platform/common/device.h"
#include "platform/desktop/window.h"

namespace dpl::platform {

class Gui {
public:
    /** pass: a pass with one RGBA8 or BGRA8 attachment of display values and one sample. Uploads the font and waits for it. At most one at
     *  a time; window and device must outlive it. scale: pixels of the picture for one of ImGui's coordinates, from 0.5 to 4. */
    static Result<std::unique_ptr<Gui>> create(const Window& window, Device& device, VkRenderPass pass, uint32_t framesInFlight,
                                               float scale);
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    /** Between these two the app calls ImGui. size: of the picture, px. */
    void beginFrame(VkExtent2D size);
    void endFrame();
    /** Inside the pass. */
    Status record(VkCommandBuffer commands) const;

private:
    Gui(Device& device, float scale) : device_(device), scale_(scale) {}
    Status make(const Window& window, VkRenderPass pass, uint32_t framesInFlight);

    Device& device_;
    const float scale_;
    bool begun_ = false;  // Dear ImGui has something to end
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
};

}  // namespace dpl::platform
