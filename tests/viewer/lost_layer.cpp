// SPDX-License-Identifier: Apache-2.0
// A Vulkan layer that loses devices. While the file $DOPPEL_LOSE_DEVICES is there, the next submission loses its device: it and all later
// calls of that device that can say so return VK_ERROR_DEVICE_LOST. The file holds how many devices are to be lost; the last takes it away.
//
// What runs on the device has ended before it is lost, so that its objects may be destroyed, as those of a device that was reset.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "tests/limits/layer_link.h"

namespace dpl::limits {
namespace {

#define DPL_NEXT_DEVICE(DO)   \
    DO(vkAcquireNextImageKHR) \
    DO(vkDestroyDevice)       \
    DO(vkDeviceWaitIdle)      \
    DO(vkGetFenceStatus)      \
    DO(vkQueuePresentKHR) DO(vkQueueSubmit) DO(vkQueueWaitIdle) DO(vkWaitForFences)

#define DPL_MEMBER(name) PFN_##name name = nullptr;

struct Instance {
    VkInstance handle = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr nextProc = nullptr;
};

struct Device {
    VkDevice handle = VK_NULL_HANDLE;
    PFN_vkGetDeviceProcAddr nextProc = nullptr;
    DPL_NEXT_DEVICE(DPL_MEMBER)
    std::atomic<bool> lost{false};
};

std::mutex tablesMutex;
std::unordered_map<void*, std::shared_ptr<Instance>> instances;
std::unordered_map<void*, std::shared_ptr<Device>> devices;

template <class Handle>
std::shared_ptr<Instance> instanceOf(Handle handle) {
    std::lock_guard lock(tablesMutex);
    return instances.at(keyOf(handle));
}
template <class Handle>
std::shared_ptr<Device> deviceOf(Handle handle) {
    std::lock_guard lock(tablesMutex);
    return devices.at(keyOf(handle));
}

/** Whether another device is to be lost; counts it. */
bool wanted() {
    const char* file = std::getenv("DOPPEL_LOSE_DEVICES");
    if (!file) return false;
    int count = 0;
    if (!(std::ifstream(file) >> count)) return false;  // none, or it is being written
    if (count > 1)
        std::ofstream(file) << count - 1;
    else
        std::remove(file);
    return count > 0;
}

VKAPI_ATTR VkResult VKAPI_CALL queueSubmit(VkQueue queue, uint32_t count, const VkSubmitInfo* infos, VkFence fence) {
    const auto device = deviceOf(queue);
    if (!device->lost && wanted()) {
        device->vkDeviceWaitIdle(device->handle);  // whoever submits holds the queue
        device->lost = true;
        std::fputs("lost layer: a device is lost\n", stderr);
    }
    return device->lost ? VK_ERROR_DEVICE_LOST : device->vkQueueSubmit(queue, count, infos, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL queueWaitIdle(VkQueue queue) {
    const auto device = deviceOf(queue);
    return device->lost ? VK_ERROR_DEVICE_LOST : device->vkQueueWaitIdle(queue);
}

VKAPI_ATTR VkResult VKAPI_CALL queuePresent(VkQueue queue, const VkPresentInfoKHR* info) {
    const auto device = deviceOf(queue);
    return device->lost ? VK_ERROR_DEVICE_LOST : device->vkQueuePresentKHR(queue, info);
}

VKAPI_ATTR VkResult VKAPI_CALL deviceWaitIdle(VkDevice handle) {
    const auto device = deviceOf(handle);
    return device->lost ? VK_ERROR_DEVICE_LOST : device->vkDeviceWaitIdle(handle);
}

VKAPI_ATTR VkResult VKAPI_CALL waitForFences(VkDevice handle, uint32_t count, const VkFence* fences, VkBool32 all, uint64_t timeoutNs) {
    const auto device = deviceOf(handle);
    return device->lost ? VK_ERROR_DEVICE_LOST : device->vkWaitForFences(handle, count, fences, all, timeoutNs);
}

VKAPI_ATTR VkResult VKAPI_CALL getFenceStatus(VkDevice handle, VkFence fence) {
    const auto device = deviceOf(handle);
    return device->lost ? VK_ERROR_DEVICE_LOST : device->vkGetFenceStatus(handle, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL acquireNextImage(VkDevice handle, VkSwapchainKHR swapchain, uint64_t timeoutNs, VkSemaphore semaphore,
                                                VkFence fence, uint32_t* index) {
    const auto device = deviceOf(handle);
    return device->lost ? VK_ERROR_DEVICE_LOST : device->vkAcquireNextImageKHR(handle, swapchain, timeoutNs, semaphore, fence, index);
}

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                              VkInstance* instance) {
    auto* link = linkIn<VkLayerInstanceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    const auto nextProc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(nextProc(VK_NULL_HANDLE, "vkCreateInstance"));
    if (!create) return VK_ERROR_INITIALIZATION_FAILED;
    if (const VkResult result = create(info, allocator, instance); result != VK_SUCCESS) return result;
    std::lock_guard lock(tablesMutex);
    instances[keyOf(*instance)] = std::make_shared<Instance>(Instance{*instance, nextProc});
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroyInstance(VkInstance instance, const VkAllocationCallbacks* allocator) {
    if (!instance) return;
    void* const key = keyOf(instance);
    const auto destroy = reinterpret_cast<PFN_vkDestroyInstance>(instanceOf(instance)->nextProc(instance, "vkDestroyInstance"));
    destroy(instance, allocator);
    std::lock_guard lock(tablesMutex);
    instances.erase(key);
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* allocator, VkDevice* device) {
    auto* link = linkIn<VkLayerDeviceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    auto made = std::make_shared<Device>();
    const auto nextInstanceProc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    made->nextProc = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(nextInstanceProc(instanceOf(physical)->handle, "vkCreateDevice"));
    if (!create) return VK_ERROR_INITIALIZATION_FAILED;
    if (const VkResult result = create(physical, info, allocator, device); result != VK_SUCCESS) return result;
    made->handle = *device;
#define DPL_LOAD(name) made->name = reinterpret_cast<PFN_##name>(made->nextProc(*device, #name));
    DPL_NEXT_DEVICE(DPL_LOAD)
#undef DPL_LOAD
    std::lock_guard lock(tablesMutex);
    devices[keyOf(*device)] = made;
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroyDevice(VkDevice device, const VkAllocationCallbacks* allocator) {
    if (!device) return;
    void* const key = keyOf(device);
    const auto gone = deviceOf(device);
    gone->vkDestroyDevice(device, allocator);
    std::lock_guard lock(tablesMutex);
    devices.erase(key);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProc(VkDevice device, const char* name);
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProc(VkInstance instance, const char* name);

PFN_vkVoidFunction ownInstanceFunction(const char* name) {
    return find({{"vkGetInstanceProcAddr", untyped(getInstanceProc)},
                 {"vkCreateInstance", untyped(createInstance)},
                 {"vkDestroyInstance", untyped(destroyInstance)},
                 {"vkCreateDevice", untyped(createDevice)}},
                name);
}

PFN_vkVoidFunction ownDeviceFunction(const char* name) {
    return find({{"vkGetDeviceProcAddr", untyped(getDeviceProc)},
                 {"vkDestroyDevice", untyped(destroyDevice)},
                 {"vkQueueSubmit", untyped(queueSubmit)},
                 {"vkQueueWaitIdle", untyped(queueWaitIdle)},
                 {"vkQueuePresentKHR", untyped(queuePresent)},
                 {"vkDeviceWaitIdle", untyped(deviceWaitIdle)},
                 {"vkWaitForFences", untyped(waitForFences)},
                 {"vkGetFenceStatus", untyped(getFenceStatus)},
                 {"vkAcquireNextImageKHR", untyped(acquireNextImage)}},
                name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProc(VkDevice device, const char* name) {
    const auto next = deviceOf(device)->nextProc(device, name);
    const auto own = ownDeviceFunction(name);
    return own && next ? own : next;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProc(VkInstance instance, const char* name) {
    if (const auto own = ownInstanceFunction(name)) return own;
    if (const auto own = ownDeviceFunction(name)) return own;
    return instance ? instanceOf(instance)->nextProc(instance, name) : nullptr;
}

}  // namespace
}  // namespace dpl::limits

extern "C" __attribute__((visibility("default"))) VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
    if (!version || version->sType != LAYER_NEGOTIATE_INTERFACE_STRUCT || version->loaderLayerInterfaceVersion < 2)
        return VK_ERROR_INITIALIZATION_FAILED;
    version->loaderLayerInterfaceVersion = 2;
    version->pfnGetInstanceProcAddr = dpl::limits::getInstanceProc;
    version->pfnGetDeviceProcAddr = dpl::limits::getDeviceProc;
    version->pfnGetPhysicalDeviceProcAddr = nullptr;
    return VK_SUCCESS;
}
