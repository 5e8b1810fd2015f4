// SPDX-License-Identifier: Apache-2.0
// Opens a device of the backend's own with all that can be said about it. Doppel says no more than VulkanOptions; tests pick, watch and
// narrow a device, and benches bring shaders of their own.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "sdk/backend/backend.h"
#include "sdk/backend/shader_pack.h"

namespace dpl::vk {

struct DeviceRequest {
    bool allowSoftware = false;                    // as VulkanOptions
    std::string name;                              // part of the device's name; empty: the best device
    bool quirks = true;                            // apply the rows of vk_quirks.cpp
    std::function<void(DeviceInfo& info)> narrow;  // takes features away, after the quirks; empty: none
    /** Counts warnings and errors of VK_LAYER_KHRONOS_validation, with synchronisation checks; their texts go to the log. Null: without
     *  the layer. */
    std::shared_ptr<std::atomic<uint32_t>> validationMessages;
};

/** As createVulkanBackend(VulkanOptions), and Code::NotFound when validation is wanted and the layer is not installed. */
Result<std::unique_ptr<Backend>> createBackend(const DeviceRequest& request, ShaderPack pack);

}  // namespace dpl::vk
