// SPDX-License-Identifier: Apache-2.0
// The shell's Vulkan instance and device, with the queue that the shell and Doppel share.
#pragma once

#include <doppel/doppel_vulkan.h>

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "platform/common/vulkan_help.h"

namespace dpl::platform {

/** How a platform shows pictures: what its surfaces need of an instance and a device. */
struct Presentation {
    std::string applicationName;
    std::vector<const char*> instanceExtensions;  // static texts
    /** Whether a queue family can show pictures. Empty: every one can. Called while the device is made. */
    std::function<bool(VkInstance, VkPhysicalDevice, uint32_t family)> canPresent;
    bool validation = false;  // load the validation layer with synchronisation validation, and collect what it says
};

class Device {
public:
    /** Takes the best device that can show pictures: a discrete GPU before an integrated one before an emulated one.
     *  DPL_ERROR_UNSUPPORTED: there is no such device, or no validation layer where one is wanted; the sentence says which. */
    static Result<std::unique_ptr<Device>> create(const Presentation& presentation);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const VulkanHandles& handles() const { return handles_; }
    VkDevice device() const { return handles_.device; }
    VkPhysicalDevice physical() const { return handles_.physical; }
    VkInstance instance() const { return instance_; }
    VkQueue queue() const { return queue_; }
    uint32_t family() const { return family_; }
    const std::string& name() const { return name_; }

    /** For dplCreateVulkanContext. Doppel takes the queue's lock through it, so it may load on another thread. */
    DplVulkanDevice forDoppel();

    Status submit(const VkSubmitInfo& info, VkFence fence);
    VkResult present(const VkPresentInfoKHR& info);
    Status waitIdle();
    /** Records commands, submits them and waits. For start-up only. */
    Status runOnce(const std::function<void(VkCommandBuffer)>& record);

    /** Warnings and errors of the validation layer so far. Any thread. */
    std::vector<std::string> complaints() const;

private:
    Device() = default;
    Status makeInstance(const Presentation& presentation);
    Status choosePhysical(const Presentation& presentation);
    Status makeDevice();

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VulkanHandles handles_;
    VkQueue queue_ = VK_NULL_HANDLE;
    uint32_t family_ = 0;
    VkPhysicalDeviceFeatures2 enabled_{};
    std::string name_;
    std::mutex queueMutex_;
    mutable std::mutex complaintsMutex_;
    std::vector<std::string> complaints_;
};

}  // namespace dpl::platform
