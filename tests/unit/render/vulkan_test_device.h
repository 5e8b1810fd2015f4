// SPDX-License-Identifier: Apache-2.0
// One Vulkan renderer for a test, or a skip with the reason. Validation is always on where the layer is installed.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "sdk/backend/vulkan/vulkan_test_options.h"
#include "sdk/render/vulkan_renderer.h"

namespace dpl {

/** The device whose name contains $DOPPEL_VULKAN_DEVICE, otherwise the best one; software devices are allowed. With DOPPEL_PLAIN_BUFFERS
 *  lavapipe too runs the kernels that GPUs run. */
inline VulkanTestOptions testVulkanOptions() {
    VulkanTestOptions options;
    options.allowSoftwareDevice = true;
    options.preciseBlending = false;  // 8-bit blending has the larger errors; withPreciseBlending() selects the product's 16 bits
    options.enableValidation = !std::getenv("DOPPEL_NO_VALIDATION");
    options.typedBuffers = !std::getenv("DOPPEL_PLAIN_BUFFERS");
    if (const char* name = std::getenv("DOPPEL_VULKAN_DEVICE")) options.deviceName = name;
    options.validationMessages = std::make_shared<std::atomic<uint32_t>>(0);
    return options;
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
        auto made = createVulkanRenderer(options, fill);
        if (!made && made.error().code == Code::NotFound) {  // no validation layer: print a note and test without it
            std::printf("[   NOTE   ] %s\n", made.error().message.c_str());
            options.enableValidation = false;
            made = createVulkanRenderer(options, fill);
        }
        if (made)
            renderer = std::move(*made);
        else
            missing = made.error().message;
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
