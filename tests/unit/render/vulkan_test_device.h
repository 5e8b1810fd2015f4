// SPDX-License-Identifier: Apache-2.0
// One Vulkan renderer for a test, or a skip with the reason. Validation is always on where the layer is installed.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "sdk/backend/vulkan/vk_open.h"
#include "sdk/backend/vulkan/vulkan_backend.h"
#include "sdk/render/gpu_renderer.h"

namespace dpl {

struct VulkanTestOptions {
    bool enableValidation = true;
    std::string deviceName;         // part of the name of the wanted device; empty: the best device
    bool withoutMultiview = false;  // draw each view by itself, as on devices without multiview
    bool typedBuffers = true;       // false: kernels with plain buffers, even where a driver needs typed ones (vk_quirks.cpp)
    bool shuffle = true;            // false: kernels without subgroup shuffles, even if DeviceInfo::shuffle
    bool ignoreQuirks = false;      // do not apply the rows of vk_quirks.cpp
    std::shared_ptr<std::atomic<uint32_t>> validationMessages = std::make_shared<std::atomic<uint32_t>>(0);

    vk::DeviceRequest request() const {
        vk::DeviceRequest request;
        request.allowSoftware = true;
        request.name = deviceName;
        request.quirks = !ignoreQuirks;
        request.narrow = [multiview = !withoutMultiview, shuffle = shuffle, texels = typedBuffers](DeviceInfo& info) {
            info.multiview &= multiview, info.shuffle &= shuffle, info.texels &= texels;
        };
        if (enableValidation) request.validationMessages = validationMessages;
        return request;
    }
};

/** The device whose name contains $DOPPEL_VULKAN_DEVICE, otherwise the best one; software devices are allowed. With DOPPEL_PLAIN_BUFFERS
 *  lavapipe too runs the kernels that GPUs run. */
inline VulkanTestOptions testVulkanOptions() {
    VulkanTestOptions options;
    options.enableValidation = !std::getenv("DOPPEL_NO_VALIDATION");
    options.typedBuffers = !std::getenv("DOPPEL_PLAIN_BUFFERS");
    if (const char* name = std::getenv("DOPPEL_VULKAN_DEVICE")) options.deviceName = name;
    return options;
}

/** As createVulkanBackend(VulkanOptions). Where validation is wanted and its layer is not installed, it says so and goes without. */
inline Result<std::unique_ptr<Backend>> createTestBackend(VulkanTestOptions options = testVulkanOptions()) {
    DPL_TRY(ShaderPack pack, readShaderPack(embeddedShaderPack(), "the embedded shader pack", embeddedShaderInterface()));
    auto made = vk::createBackend(options.request(), pack);
    if (made || made.error().code != Code::NotFound) return made;
    std::printf("[   NOTE   ] %s\n", made.error().message.c_str());
    options.enableValidation = false;
    return vk::createBackend(options.request(), std::move(pack));
}

/** With vectors of 512 bits lavapipe 22.3.6 crashes while it compiles fragment shaders for targets of 16-bit floats. The faulting thread
 *  runs only the driver: it is inside LLVM's BitCastInst, called by libvulkan_lvp. In the four core dumps that were read, a use-list
 * pointer holds the text "p_mask". */
inline bool lavapipeCompilerCrashes() {
    const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH");
    return width && std::string(width) == "512";
}

/** A renderer and its counter of validation messages. The destructor expects that there was none. */
struct TestVulkan {
    VulkanTestOptions options;
    Fill fill;
    std::unique_ptr<Renderer> renderer;
    std::string missing;  // why there is no renderer
    DeviceInfo device;    // as the driver describes it, without the work-arounds for single drivers

    TestVulkan() : TestVulkan(testVulkanOptions()) {}
    explicit TestVulkan(VulkanTestOptions wanted, Fill fill = Fill::Quads) : options(std::move(wanted)), fill(fill) {
        auto devices = listVulkanDevices();
        if (!devices || devices->empty()) {
            missing = devices ? "no Vulkan 1.1 device here" : devices.error().message;
            return;
        }
        const auto named = std::find_if(devices->begin(), devices->end(),
                                        [&](const DeviceInfo& d) { return d.name.find(options.deviceName) != std::string::npos; });
        if (named != devices->end()) device = *named;
        if (fill == Fill::Quads && lavapipeCompilerCrashes()) {
            missing = "lavapipe dies compiling quads with 512-bit vectors";
            return;
        }
        auto made = createTestBackend(options);
        if (!made) {
            missing = made.error().message;
            return;
        }
        std::string name = "vulkan: " + (*made)->info().name;
        renderer = std::make_unique<GpuRenderer>(std::move(*made), std::move(name), fill);
    }
    ~TestVulkan() {
        renderer.reset();  // the validation layer reports leaks when the device is destroyed
        EXPECT_EQ(options.validationMessages->load(), 0u) << "validation layer messages, see the log above";
    }
};

}  // namespace dpl

#define DPL_NEED_VULKAN(vulkan) \
    if (!(vulkan).renderer) GTEST_SKIP() << (vulkan).missing
#define DPL_NEED_FOUR_SAMPLES(vulkan) \
    DPL_NEED_VULKAN(vulkan);          \
    if (!(vulkan).device.fourSamples) GTEST_SKIP() << (vulkan).device.name << " draws one sample a pixel"
