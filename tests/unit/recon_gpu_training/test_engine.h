// SPDX-License-Identifier: Apache-2.0
// One engine for a test program, or none, with the reason.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "reconstruction/training/gpu/gpu_engine.h"

namespace dpl::test {

/** The device of the tests, with validation where the layer is installed; null, with the reason printed, where there is none. */
inline GpuEngine* testEngine() {
    static std::shared_ptr<std::atomic<uint32_t>> messages = std::make_shared<std::atomic<uint32_t>>(0);
    static const auto made = [] {
        vk::DeviceRequest request;
        request.allowSoftware = true, request.validationMessages = messages;
        if (const char* name = std::getenv("DOPPEL_VULKAN_DEVICE")) request.name = name;
        auto engine = GpuEngine::create(request);
        if (!engine && engine.error().code == Code::NotFound) request.validationMessages.reset(), engine = GpuEngine::create(request);
        if (!engine) std::printf("[   NOTE   ] %s\n", engine.error().message.c_str());
        return engine ? std::move(*engine) : nullptr;
    }();
    EXPECT_EQ(*messages, 0u) << "validation messages so far";
    return made.get();
}

}  // namespace dpl::test
