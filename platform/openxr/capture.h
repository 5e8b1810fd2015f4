// SPDX-License-Identifier: Apache-2.0
// Copies what a frame submits to the CPU, for tests and screenshots. Internal to this room.
#pragma once

#include "platform/openxr/images.h"

namespace dpl::xr {

class Capture {
public:
    explicit Capture(const Runtime& runtime) : runtime_(runtime) {}
    ~Capture() { clear(); }
    Capture(const Capture&) = delete;
    Capture& operator=(const Capture&) = delete;

    /** Makes a buffer for each view. */
    Status begin(const SessionImages& images);
    /** Records the copies, after all drawing. Depth images come and go in DEPTH_STENCIL_READ_ONLY_OPTIMAL. */
    void record(VkCommandBuffer commands, const Images& images) const;
    /** Once the GPU has run the commands: colour and depth of every view, sizes and formats. */
    Status read(const SessionImages& images, float nearM, std::vector<CapturedView>& views);

private:
    struct Buffer {
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        VkDeviceSize colourBytes = 0, depthBytes = 0;  // depth follows colour
    };
    Status makeBuffer(VkDeviceSize bytes, Buffer& buffer);
    void clear();

    const Runtime& runtime_;
    std::vector<Buffer> buffers_;  // by view
};

}  // namespace dpl::xr
