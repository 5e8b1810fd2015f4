// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "reconstruction/training/gpu/vulkan_engine.h"
#include "tests/unit/recon_gpu_training/test_engine.h"

namespace dpl::test {

GpuEngine* testEngine() {  // with validation where the layer is installed
    static std::shared_ptr<std::atomic<uint32_t>> messages = std::make_shared<std::atomic<uint32_t>>(0);
    static const auto made = [] {
        vk::DeviceRequest request;
        request.allowSoftware = true, request.validationMessages = messages;
        if (const char* name = std::getenv("DOPPEL_VULKAN_DEVICE")) request.name = name;
        auto engine = createVulkanEngine(request);
        if (!engine && engine.error().code == Code::NotFound) request.validationMessages.reset(), engine = createVulkanEngine(request);
        if (!engine) std::printf("[   NOTE   ] %s\n", engine.error().message.c_str());
        return engine ? std::move(*engine) : nullptr;
    }();
    EXPECT_EQ(*messages, 0u) << "validation messages so far";
    return made.get();
}

}  // namespace dpl::test
