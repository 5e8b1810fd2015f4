// SPDX-License-Identifier: Apache-2.0
// The shell's Vulkan instance and device, with the queue that the shell and Doppel share.
#pragma once

#include <doppel/doppel_vulkan.h>

#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "platform/common/vulkan_help.h"
#include "platform/desktop/window.h"

namespace dpl::platform {

class Device {
public:
    /** Takes the best device that can show pictures in the window: a discrete GPU before an integrated one before an emulated one.
     *  validation: loads the validation layer with synchronisation validation, and collects what it says. Throws a sentence if there is no
     *  such device or no such layer. The window must outlive the device. */
    Device(const Window& window, bool validation);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const VulkanHandles& handles() const { return handles_; }
    VkDevice device() const { return handles_.device; }
    VkPhysicalDevice physical() const { return handles_.physical; }
    VkInstance instance() const { return instance_; }
    VkSurfaceKHR surface() const { return surface_; }
    VkQueue queue() const { return queue_; }
    uint32_t family() const { return family_; }
    const std::string& name() const { return name_; }

    /** For dplCreateVulkanContext. Doppel takes the queue's lock through it, so it may load on another thread. */
    DplVulkanDevice forDoppel();

    void submit(const VkSubmitInfo& info, VkFence fence);
    VkResult present(const VkPresentInfoKHR& info);
    void waitIdle();
    /** Records commands, submits them and waits. For start-up only. */
    void runOnce(const std::function<void(VkCommandBuffer)>& record);

    /** Warnings and errors of the validation layer so far. Any thread. */
    std::vector<std::string> complaints() const;

private:
    void makeInstance(bool validation);
    void choosePhysical();
    void makeDevice();
    void destroy();

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
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
