// SPDX-License-Identifier: Apache-2.0
// A Vulkan layer that shows pictures in the windows of fake_window.h, on any driver that has VK_KHR_swapchain. Tests say what goes wrong.
// As on Android, a window has one swapchain at a time, its size and its transform are those of the moment, and the compositor reads what
// was presented: here into memory, before vkQueuePresentKHR returns.
#include <algorithm>
#include <cstring>
#include <memory>
#include <unordered_map>
#include <utility>

#include "tests/android/fake_window.h"

#include <vulkan/vk_layer.h>

namespace dpl::window_layer {
namespace {

#define DPL_NEXT_INSTANCE(DO) \
    DO(vkDestroyInstance)     \
    DO(vkGetPhysicalDeviceMemoryProperties)

#define DPL_NEXT_DEVICE(DO)           \
    DO(vkAllocateCommandBuffers)      \
    DO(vkAllocateMemory)              \
    DO(vkBeginCommandBuffer)          \
    DO(vkBindBufferMemory)            \
    DO(vkBindImageMemory)             \
    DO(vkCmdCopyImageToBuffer)        \
    DO(vkCmdPipelineBarrier)          \
    DO(vkCreateBuffer)                \
    DO(vkCreateCommandPool)           \
    DO(vkCreateImage)                 \
    DO(vkDestroyBuffer)               \
    DO(vkDestroyCommandPool)          \
    DO(vkDestroyDevice)               \
    DO(vkDestroyImage)                \
    DO(vkEndCommandBuffer)            \
    DO(vkFreeMemory)                  \
    DO(vkGetBufferMemoryRequirements) \
    DO(vkGetDeviceQueue)              \
    DO(vkGetImageMemoryRequirements)  \
    DO(vkMapMemory)                   \
    DO(vkQueueSubmit)                 \
    DO(vkQueueWaitIdle)

#define DPL_MEMBER(name) PFN_##name name = nullptr;

struct Instance {
    VkInstance handle = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr nextProc = nullptr;
    DPL_NEXT_INSTANCE(DPL_MEMBER)
};

struct Device {
    VkDevice handle = VK_NULL_HANDLE;
    PFN_vkGetDeviceProcAddr nextProc = nullptr;
    DPL_NEXT_DEVICE(DPL_MEMBER)
    VkPhysicalDeviceMemoryProperties memory{};
    VkQueue queue = VK_NULL_HANDLE;

    uint32_t memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const {
        for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
            if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
        return 0;
    }
};

struct Swapchain {
    ANativeWindow* window = nullptr;
    VkExtent2D size{};
    VkSurfaceTransformFlagBitsKHR transform{};
    std::vector<VkImage> images;
    std::vector<VkDeviceMemory> memory;
    std::vector<bool> acquired;
    uint32_t next = 0;
    bool retired = false;
    VkBuffer read = VK_NULL_HANDLE;
    VkDeviceMemory readMemory = VK_NULL_HANDLE;
    void* mapped = nullptr;
    VkCommandPool pool = VK_NULL_HANDLE;
};

template <class Handle>
void* keyOf(Handle handle) {
    return *reinterpret_cast<void**>(handle);
}
template <class Handle, class Object>
Handle handleTo(Object* object) {
    return Handle(reinterpret_cast<uintptr_t>(object));
}
template <class Object, class Handle>
Object* objectOf(Handle handle) {
    return reinterpret_cast<Object*>(uintptr_t(handle));
}

std::mutex tablesMutex;
std::unordered_map<void*, std::shared_ptr<Instance>> instances;
std::unordered_map<void*, std::shared_ptr<Device>> devices;
thread_local ANativeWindow* nextWindow = nullptr;
std::atomic<VkResult> nextSubmit{VK_SUCCESS};

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

template <class Link, class Info>
Link* linkIn(const Info& info, VkStructureType type) {
    for (auto* at = static_cast<const VkBaseInStructure*>(info.pNext); at; at = at->pNext)
        if (auto* link = reinterpret_cast<const Link*>(at); at->sType == type && link->function == VK_LAYER_LINK_INFO)
            return const_cast<Link*>(link);
    return nullptr;
}

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                              VkInstance* instance) {
    auto* link = linkIn<VkLayerInstanceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    const auto nextProc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(nextProc(VK_NULL_HANDLE, "vkCreateInstance"));
    if (const VkResult result = create(info, allocator, instance); result != VK_SUCCESS) return result;
    auto made = std::make_shared<Instance>();
    made->handle = *instance;
    made->nextProc = nextProc;
#define DPL_LOAD(name) made->name = reinterpret_cast<PFN_##name>(nextProc(*instance, #name));
    DPL_NEXT_INSTANCE(DPL_LOAD)
#undef DPL_LOAD
    std::lock_guard lock(tablesMutex);
    instances[keyOf(*instance)] = made;
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroyInstance(VkInstance instance, const VkAllocationCallbacks* allocator) {
    if (!instance) return;
    const auto gone = instanceOf(instance);
    void* const key = keyOf(instance);
    gone->vkDestroyInstance(instance, allocator);
    std::lock_guard lock(tablesMutex);
    instances.erase(key);
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* allocator, VkDevice* device) {
    auto* link = linkIn<VkLayerDeviceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    auto made = std::make_shared<Device>();
    const auto instance = instanceOf(physical);
    instance->vkGetPhysicalDeviceMemoryProperties(physical, &made->memory);
    const auto nextInstanceProc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    made->nextProc = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(nextInstanceProc(instance->handle, "vkCreateDevice"));
    if (const VkResult result = create(physical, info, allocator, device); result != VK_SUCCESS) return result;
    made->handle = *device;
#define DPL_LOAD(name) made->name = reinterpret_cast<PFN_##name>(made->nextProc(*device, #name));
    DPL_NEXT_DEVICE(DPL_LOAD)
#undef DPL_LOAD
    made->vkGetDeviceQueue(*device, info->pQueueCreateInfos->queueFamilyIndex, 0, &made->queue);
    std::lock_guard lock(tablesMutex);
    devices[keyOf(*device)] = made;
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroyDevice(VkDevice device, const VkAllocationCallbacks* allocator) {
    if (!device) return;
    const auto gone = deviceOf(device);
    void* const key = keyOf(device);
    gone->vkDestroyDevice(device, allocator);
    std::lock_guard lock(tablesMutex);
    devices.erase(key);
}

// ── surfaces ────────────────────────────────────────────────────────────────────────────────────────────────────────────────────

VKAPI_ATTR VkResult VKAPI_CALL createSurface(VkInstance, const VkHeadlessSurfaceCreateInfoEXT*, const VkAllocationCallbacks*,
                                             VkSurfaceKHR* surface) {
    ANativeWindow* window = std::exchange(nextWindow, nullptr);
    if (!window) return VK_ERROR_INITIALIZATION_FAILED;
    ++window->surfaces;
    *surface = handleTo<VkSurfaceKHR>(window);
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroySurface(VkInstance, VkSurfaceKHR surface, const VkAllocationCallbacks*) {
    auto* window = objectOf<ANativeWindow>(surface);
    if (!window) return;
    if (window->swapchains > 0) ++window->wrong;
    --window->surfaces;
}

VKAPI_ATTR VkResult VKAPI_CALL surfaceSupport(VkPhysicalDevice, uint32_t, VkSurfaceKHR, VkBool32* supported) {
    *supported = VK_TRUE;
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL surfaceCapabilities(VkPhysicalDevice, VkSurfaceKHR surface, VkSurfaceCapabilitiesKHR* can) {
    auto& window = *objectOf<ANativeWindow>(surface);
    std::lock_guard lock(window.mutex);
    *can = {};
    can->minImageCount = 2, can->maxImageCount = 64;
    can->currentExtent = {window.width, window.height};
    can->minImageExtent = {1, 1}, can->maxImageExtent = {4096, 4096};
    can->maxImageArrayLayers = 1;
    can->supportedTransforms = can->currentTransform = window.transform;
    can->supportedTransforms |= VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR;
    can->supportedCompositeAlpha = VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;  // as Android
    can->supportedUsageFlags = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    return VK_SUCCESS;
}

template <class T>
VkResult oneOf(const T& value, uint32_t* count, T* out) {
    if (!out) return *count = 1, VK_SUCCESS;
    if (*count == 0) return VK_INCOMPLETE;
    *count = 1, *out = value;
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL surfaceFormats(VkPhysicalDevice, VkSurfaceKHR surface, uint32_t* count, VkSurfaceFormatKHR* formats) {
    auto& window = *objectOf<ANativeWindow>(surface);
    std::lock_guard lock(window.mutex);
    return oneOf(VkSurfaceFormatKHR{window.format, VK_COLOR_SPACE_SRGB_NONLINEAR_KHR}, count, formats);
}

VKAPI_ATTR VkResult VKAPI_CALL surfaceModes(VkPhysicalDevice, VkSurfaceKHR, uint32_t* count, VkPresentModeKHR* modes) {
    return oneOf(VK_PRESENT_MODE_FIFO_KHR, count, modes);
}

// ── swapchains ──────────────────────────────────────────────────────────────────────────────────────────────────────────────────

VKAPI_ATTR VkResult VKAPI_CALL createSwapchain(VkDevice device, const VkSwapchainCreateInfoKHR* info, const VkAllocationCallbacks*,
                                               VkSwapchainKHR* swapchain) {
    const auto d = deviceOf(device);
    auto* window = objectOf<ANativeWindow>(info->surface);
    auto* old = objectOf<Swapchain>(info->oldSwapchain);
    if (old) old->retired = true, window->hasImages = false;
    {
        std::lock_guard lock(window->mutex);
        if (const VkResult told = std::exchange(window->nextSwapchain, VK_SUCCESS); told != VK_SUCCESS) return told;
    }
    if (window->hasImages.exchange(true)) return VK_ERROR_NATIVE_WINDOW_IN_USE_KHR;
    auto made = std::make_unique<Swapchain>();
    made->window = window, made->size = info->imageExtent, made->transform = info->preTransform;
    for (uint32_t i = 0; i < info->minImageCount; ++i) {
        VkImageCreateInfo image{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
        image.imageType = VK_IMAGE_TYPE_2D;
        image.format = info->imageFormat;
        image.extent = {info->imageExtent.width, info->imageExtent.height, 1};
        image.mipLevels = image.arrayLayers = 1;
        image.samples = VK_SAMPLE_COUNT_1_BIT;
        image.usage = info->imageUsage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
        VkMemoryRequirements needs{};
        d->vkCreateImage(device, &image, nullptr, &made->images.emplace_back());
        d->vkGetImageMemoryRequirements(device, made->images.back(), &needs);
        const VkMemoryAllocateInfo memory{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size,
                                          d->memoryType(needs.memoryTypeBits, 0)};
        d->vkAllocateMemory(device, &memory, nullptr, &made->memory.emplace_back());
        d->vkBindImageMemory(device, made->images.back(), made->memory.back(), 0);
    }
    made->acquired.resize(made->images.size());
    VkBufferCreateInfo buffer{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    buffer.size = VkDeviceSize(made->size.width) * made->size.height * 4;
    buffer.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    d->vkCreateBuffer(device, &buffer, nullptr, &made->read);
    VkMemoryRequirements needs{};
    d->vkGetBufferMemoryRequirements(device, made->read, &needs);
    constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryAllocateInfo memory{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size,
                                      d->memoryType(needs.memoryTypeBits, kHost)};
    d->vkAllocateMemory(device, &memory, nullptr, &made->readMemory);
    d->vkBindBufferMemory(device, made->read, made->readMemory, 0);
    d->vkMapMemory(device, made->readMemory, 0, VK_WHOLE_SIZE, 0, &made->mapped);
    const VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                       0};
    d->vkCreateCommandPool(device, &pool, nullptr, &made->pool);
    ++window->swapchains;
    *swapchain = handleTo<VkSwapchainKHR>(made.release());
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroySwapchain(VkDevice device, VkSwapchainKHR swapchain, const VkAllocationCallbacks*) {
    const std::unique_ptr<Swapchain> gone(objectOf<Swapchain>(swapchain));
    if (!gone) return;
    const auto d = deviceOf(device);
    for (size_t i = 0; i < gone->images.size(); ++i) {
        d->vkDestroyImage(device, gone->images[i], nullptr);
        d->vkFreeMemory(device, gone->memory[i], nullptr);
    }
    d->vkDestroyBuffer(device, gone->read, nullptr);
    d->vkFreeMemory(device, gone->readMemory, nullptr);
    d->vkDestroyCommandPool(device, gone->pool, nullptr);
    --gone->window->swapchains;
    if (!gone->retired) gone->window->hasImages = false;
}

VKAPI_ATTR VkResult VKAPI_CALL swapchainImages(VkDevice, VkSwapchainKHR swapchain, uint32_t* count, VkImage* images) {
    const auto& all = objectOf<Swapchain>(swapchain)->images;
    if (!images) return *count = uint32_t(all.size()), VK_SUCCESS;
    *count = std::min(*count, uint32_t(all.size()));
    std::copy_n(all.begin(), *count, images);
    return *count < all.size() ? VK_INCOMPLETE : VK_SUCCESS;
}

/** Whether the swapchain is of the window's present size. The window's lock is held. */
bool fits(const Swapchain& s) {
    const bool turned = s.transform & (VK_SURFACE_TRANSFORM_ROTATE_90_BIT_KHR | VK_SURFACE_TRANSFORM_ROTATE_270_BIT_KHR);
    const uint32_t width = turned ? s.window->height : s.window->width, height = turned ? s.window->width : s.window->height;
    return s.size.width == width && s.size.height == height;
}

VKAPI_ATTR VkResult VKAPI_CALL acquire(VkDevice device, VkSwapchainKHR swapchain, uint64_t, VkSemaphore semaphore, VkFence fence,
                                       uint32_t* index) {
    const auto d = deviceOf(device);
    auto& s = *objectOf<Swapchain>(swapchain);
    {
        std::lock_guard lock(s.window->mutex);
        if (const VkResult told = std::exchange(s.window->nextAcquire, VK_SUCCESS); told != VK_SUCCESS) return told;
        if (s.retired || !fits(s)) return VK_ERROR_OUT_OF_DATE_KHR;
    }
    if (s.acquired[s.next]) return VK_TIMEOUT;
    *index = s.next;
    s.acquired[s.next] = true;
    s.next = (s.next + 1) % uint32_t(s.images.size());
    VkSubmitInfo signal{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    signal.signalSemaphoreCount = semaphore != VK_NULL_HANDLE;
    signal.pSignalSemaphores = &semaphore;
    return d->vkQueueSubmit(d->queue, 1, &signal, fence);
}

/** Copies an image into memory, after its semaphores. */
VkResult show(Device& d, VkQueue queue, Swapchain& s, uint32_t index, const VkPresentInfoKHR& info) {
    const VkCommandBufferAllocateInfo allocation{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, s.pool,
                                                 VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    VkCommandBuffer commands = VK_NULL_HANDLE;
    d.vkAllocateCommandBuffers(d.handle, &allocation, &commands);
    const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    d.vkBeginCommandBuffer(commands, &begin);
    VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    barrier.oldLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = s.images[index];
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    const auto pipelineBarrier = [&] {
        d.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr,
                               1, &barrier);
    };
    pipelineBarrier();
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {s.size.width, s.size.height, 1};
    d.vkCmdCopyImageToBuffer(commands, s.images[index], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, s.read, 1, &region);
    std::swap(barrier.oldLayout, barrier.newLayout);
    pipelineBarrier();
    d.vkEndCommandBuffer(commands);
    const std::vector<VkPipelineStageFlags> stages(info.waitSemaphoreCount, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.waitSemaphoreCount = info.waitSemaphoreCount;
    submit.pWaitSemaphores = info.pWaitSemaphores, submit.pWaitDstStageMask = stages.data();
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    if (const VkResult result = d.vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE); result != VK_SUCCESS) return result;
    if (const VkResult result = d.vkQueueWaitIdle(queue); result != VK_SUCCESS) return result;
    const auto* pixels = static_cast<const uint8_t*>(s.mapped);
    std::lock_guard lock(s.window->mutex);
    s.window->shown.assign(pixels, pixels + size_t(s.size.width) * s.size.height * 4);
    s.window->shownWidth = s.size.width, s.window->shownHeight = s.size.height;
    ++s.window->shownCount;
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL present(VkQueue queue, const VkPresentInfoKHR* info) {
    const auto d = deviceOf(queue);
    auto& s = *objectOf<Swapchain>(info->pSwapchains[0]);
    const uint32_t index = info->pImageIndices[0];
    if (!s.acquired[index]) ++s.window->wrong;
    s.acquired[index] = false;
    if (const VkResult shown = show(*d, queue, s, index, *info); shown != VK_SUCCESS) return shown;
    std::lock_guard lock(s.window->mutex);
    if (const VkResult told = std::exchange(s.window->nextPresent, VK_SUCCESS); told != VK_SUCCESS) return told;
    return s.transform == s.window->transform ? VK_SUCCESS : VK_SUBOPTIMAL_KHR;
}

VKAPI_ATTR VkResult VKAPI_CALL queueSubmit(VkQueue queue, uint32_t count, const VkSubmitInfo* submits, VkFence fence) {
    if (const VkResult told = nextSubmit.exchange(VK_SUCCESS); told != VK_SUCCESS) return told;
    return deviceOf(queue)->vkQueueSubmit(queue, count, submits, fence);
}

// ── the way in ──────────────────────────────────────────────────────────────────────────────────────────────────────────────────

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProc(VkInstance instance, const char* name);
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProc(VkDevice device, const char* name);

struct Entry {
    const char* name;
    PFN_vkVoidFunction function;
};
template <class Function>
PFN_vkVoidFunction untyped(Function* function) {
    return reinterpret_cast<PFN_vkVoidFunction>(function);
}
PFN_vkVoidFunction find(std::initializer_list<Entry> entries, const char* name) {
    for (const Entry& entry : entries)
        if (std::strcmp(entry.name, name) == 0) return entry.function;
    return nullptr;
}

PFN_vkVoidFunction ownInstanceFunction(const char* name) {
    return find({{"vkGetInstanceProcAddr", untyped(getInstanceProc)},
                 {"vkCreateInstance", untyped(createInstance)},
                 {"vkDestroyInstance", untyped(destroyInstance)},
                 {"vkCreateDevice", untyped(createDevice)},
                 {"vkCreateHeadlessSurfaceEXT", untyped(createSurface)},
                 {"vkDestroySurfaceKHR", untyped(destroySurface)},
                 {"vkGetPhysicalDeviceSurfaceSupportKHR", untyped(surfaceSupport)},
                 {"vkGetPhysicalDeviceSurfaceCapabilitiesKHR", untyped(surfaceCapabilities)},
                 {"vkGetPhysicalDeviceSurfaceFormatsKHR", untyped(surfaceFormats)},
                 {"vkGetPhysicalDeviceSurfacePresentModesKHR", untyped(surfaceModes)}},
                name);
}
PFN_vkVoidFunction ownDeviceFunction(const char* name) {
    return find({{"vkGetDeviceProcAddr", untyped(getDeviceProc)},
                 {"vkDestroyDevice", untyped(destroyDevice)},
                 {"vkCreateSwapchainKHR", untyped(createSwapchain)},
                 {"vkDestroySwapchainKHR", untyped(destroySwapchain)},
                 {"vkGetSwapchainImagesKHR", untyped(swapchainImages)},
                 {"vkAcquireNextImageKHR", untyped(acquire)},
                 {"vkQueuePresentKHR", untyped(present)},
                 {"vkQueueSubmit", untyped(queueSubmit)}},
                name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProc(VkDevice device, const char* name) {
    if (const auto own = ownDeviceFunction(name)) return own;
    return deviceOf(device)->nextProc(device, name);
}
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProc(VkInstance instance, const char* name) {
    if (const auto own = ownInstanceFunction(name)) return own;
    if (const auto own = ownDeviceFunction(name)) return own;
    return instance ? instanceOf(instance)->nextProc(instance, name) : nullptr;
}

}  // namespace
}  // namespace dpl::window_layer

void dplTestNextWindow(ANativeWindow* window) {
    dpl::window_layer::nextWindow = window;
}
void dplTestNextSubmit(VkResult result) {
    dpl::window_layer::nextSubmit = result;
}

extern "C" __attribute__((visibility("default"))) VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
    if (!version || version->sType != LAYER_NEGOTIATE_INTERFACE_STRUCT || version->loaderLayerInterfaceVersion < 2)
        return VK_ERROR_INITIALIZATION_FAILED;
    version->loaderLayerInterfaceVersion = 2;
    version->pfnGetInstanceProcAddr = dpl::window_layer::getInstanceProc;
    version->pfnGetDeviceProcAddr = dpl::window_layer::getDeviceProc;
    version->pfnGetPhysicalDeviceProcAddr = nullptr;
    return VK_SUCCESS;
}
