// SPDX-License-Identifier: Apache-2.0
// Opens the Vulkan instance, device and queue that a backend uses until it is destroyed.
#pragma once

#include "sdk/backend/vulkan/vk_functions.h"
#include "sdk/backend/vulkan/vk_open.h"

namespace dpl::vk {

/** The error of a failed Vulkan call. `what`: the text of the call, which contains the function's name, or that name alone. */
Error failVk(std::string_view what, VkResult result);

// DPL_VK(call): if the Vulkan call fails, return its error from the calling function. The error is that of failVk() above or, in the
// backend, of VulkanBackend::failVk().
#define DPL_VK(...) \
    if (const VkResult dplVkResult = (__VA_ARGS__); dplVkResult != VK_SUCCESS) return failVk(#__VA_ARGS__, dplVkResult)

// DPL_VK_MAKE(handle, call): the same for a call that writes a handle. What a failed call writes is undefined, so the handle becomes null.
#define DPL_VK_MAKE(handle, ...)                                                 \
    if (const VkResult dplVkResult = (__VA_ARGS__); dplVkResult != VK_SUCCESS) { \
        handle = VK_NULL_HANDLE;                                                 \
        return failVk(#__VA_ARGS__, dplVkResult);                                \
    }                                                                            \
    static_assert(true)

/** A Vulkan device that an app opened and lends. All handles stay the app's and outlive the backend. */
struct AppDevice {
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;  // null: the machine's loader
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;  // of queueFamily; used while avatars load and for frames that the backend submits
    uint32_t queueFamily = 0;
    const VkPhysicalDeviceFeatures2* enabled = nullptr;  // chain of vkCreateDevice, read during the call; null: no feature is enabled
    const VkAllocationCallbacks* allocator = nullptr;    // read during the call; what it points to must outlive the backend
    void (*lockQueue)(void* user) = nullptr;             // around each use of the queue; null: nobody else uses it
    void (*unlockQueue)(void* user) = nullptr;
    void* user = nullptr;
};

struct Device {
    Functions vk;
    VkInstance instance = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t queueFamily = 0;
    VkPhysicalDeviceMemoryProperties memory{};
    double nanosecondsPerTick = 0;
    uint32_t timestampBits = 0;
    VkFormat depthSumFormat = VK_FORMAT_R32G32_SFLOAT;
    DeviceInfo info;
    std::shared_ptr<std::atomic<uint32_t>> validationMessages;
    bool lent = false;  // by an app, which destroys it
    bool lost = false;  // a call said so, or a frame did not end in time: nothing runs on it any more
    VkAllocationCallbacks appAllocator{};
    const VkAllocationCallbacks* allocator = nullptr;  // null, or &appAllocator
    void (*lockQueue)(void* user) = nullptr;
    void (*unlockQueue)(void* user) = nullptr;
    void* user = nullptr;

    /** Keeps others from the queue while it lives. */
    class QueueLock {
    public:
        explicit QueueLock(const Device& device) : device_(device) {
            if (device_.lockQueue) device_.lockQueue(device_.user);
        }
        ~QueueLock() {
            if (device_.unlockQueue) device_.unlockQueue(device_.user);
        }
        QueueLock(const QueueLock&) = delete;
        QueueLock& operator=(const QueueLock&) = delete;

    private:
        const Device& device_;
    };

    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    ~Device();
};

/** Code::Unsupported when there is no loader, no driver or no device that fits; Code::NotFound when the validation layer is missing. */
Result<std::unique_ptr<Device>> openDevice(const DeviceRequest& request);

/** Code::InvalidArgument: a handle is null, or the queue family does not exist. Code::Unsupported: the device is older than Vulkan 1.1, or
 *  the queue family lacks graphics or compute. */
Result<std::unique_ptr<Device>> borrowDevice(const AppDevice& app);

}  // namespace dpl::vk
