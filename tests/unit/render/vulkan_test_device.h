// SPDX-License-Identifier: Apache-2.0
// One Vulkan renderer for a test, or a skip with the reason. Validation is always on where the layer is installed.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "sdk/render/vulkan_renderer.h"

namespace dpl {

/** Device by DOPPEL_VULKAN_DEVICE (part of its name), else the best one, software included. DOPPEL_PLAIN_BUFFERS: the kernels that GPUs
 * run, and their blending. */
inline VulkanOptions testVulkanOptions() {
    VulkanOptions options;
    options.allowSoftwareDevice = true;
    options.preciseBlending = false;  // the harder path; the tests of the default ask for it
    options.enableValidation = !std::getenv("DOPPEL_NO_VALIDATION");
    options.typedBuffers = options.codes16 = !std::getenv("DOPPEL_PLAIN_BUFFERS");
    if (const char* name = std::getenv("DOPPEL_VULKAN_DEVICE")) options.deviceName = name;
    options.validationMessages = std::make_shared<std::atomic<uint32_t>>(0);
    return options;
}

/** Renderer and message counter; every test ends with expectSilent(). */
struct TestVulkan {
    VulkanOptions options;
    Fill fill;
    std::unique_ptr<Renderer> renderer;
    std::string missing;  // why there is none

    TestVulkan() : TestVulkan(testVulkanOptions()) {}
    explicit TestVulkan(VulkanOptions wanted, Fill fill = Fill::Quads) : options(std::move(wanted)), fill(fill) {
        auto devices = listVulkanDevices();
        if (!devices || devices->empty()) {
            missing = devices ? "no Vulkan 1.1 device here" : devices.error().message;
            return;
        }
        auto made = createVulkanRenderer(options, fill);
        if (!made && made.error().code == Code::NotFound) {  // no validation layer: say so, test without
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
        renderer.reset();  // leaks are reported when the device goes
        EXPECT_EQ(options.validationMessages->load(), 0u) << "validation layer messages, see the log above";
    }
};

}  // namespace dpl

#define DPL_NEED_VULKAN(vulkan) \
    if (!(vulkan).renderer) GTEST_SKIP() << (vulkan).missing
