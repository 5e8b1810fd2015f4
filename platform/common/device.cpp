// SPDX-License-Identifier: Apache-2.0
#include "platform/common/device.h"

#include <algorithm>
#include <cstring>

namespace dpl::platform {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

Result<bool> hasLayer(const char* name) {
    uint32_t count = 0;
    DPL_VK(vkEnumerateInstanceLayerProperties(&count, nullptr));
    std::vector<VkLayerProperties> layers(count);
    DPL_VK(vkEnumerateInstanceLayerProperties(&count, layers.data()));
    layers.resize(count);
    return std::any_of(layers.begin(), layers.end(), [&](const auto& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

Result<bool> hasSwapchains(VkPhysicalDevice physical) {
    uint32_t count = 0;
    DPL_VK(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr));
    std::vector<VkExtensionProperties> extensions(count);
    DPL_VK(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data()));
    extensions.resize(count);
    return std::any_of(extensions.begin(), extensions.end(),
                       [](const auto& e) { return std::strcmp(e.extensionName, VK_KHR_SWAPCHAIN_EXTENSION_NAME) == 0; });
}

/** The first queue family that draws, computes and presents; -1: none. */
int familyOf(VkInstance instance, VkPhysicalDevice physical, const Presentation& presentation) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    constexpr VkQueueFlags kNeeded = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    for (uint32_t i = 0; i < count; ++i) {
        if ((families[i].queueFlags & kNeeded) != kNeeded) continue;
        if (!presentation.canPresent || presentation.canPresent(instance, physical, i)) return int(i);
    }
    return -1;
}

/** Larger is better. */
int rankOf(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return 4;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return 3;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return 2;
        default:
            return 1;
    }
}

}  // namespace

Result<std::unique_ptr<Device>> Device::create(const Presentation& presentation) {
    std::unique_ptr<Device> made(new Device);
    DPL_SHELL_OK(made->makeInstance(presentation));
    DPL_SHELL_OK(made->choosePhysical(presentation));
    DPL_SHELL_OK(made->makeDevice());
    return made;
}

Device::~Device() {
    if (handles_.device) vkDestroyDevice(handles_.device, nullptr);
    if (!instance_) return;
    if (messenger_)
        reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"))(
            instance_, messenger_, nullptr);
    vkDestroyInstance(instance_, nullptr);
}

Status Device::makeInstance(const Presentation& presentation) {
    const bool validation = presentation.validation;
    std::vector<const char*> extensions = presentation.instanceExtensions;
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = presentation.applicationName.c_str();
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    const VkValidationFeatureEnableEXT synchronisation = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronisation;
    if (validation) {
        DPL_SHELL_TRY(const bool installed, hasLayer(kValidationLayer));
        if (!installed)
            return Error{DPL_ERROR_UNSUPPORTED, "the Vulkan validation layer is not installed (Debian: vulkan-validationlayers)"};
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
        info.pNext = &features;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &kValidationLayer;
    }
    info.enabledExtensionCount = uint32_t(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    VkInstance instance = VK_NULL_HANDLE;  // what a failed call writes is undefined
    DPL_VK(vkCreateInstance(&info, nullptr, &instance));
    instance_ = instance;
    if (!validation) return {};
    VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pUserData = this;
    messenger.pfnUserCallback = [](VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                   const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) -> VkBool32 {
        auto& self = *static_cast<Device*>(user);
        std::lock_guard lock(self.complaintsMutex_);
        self.complaints_.push_back(data->pMessage);
        return VK_FALSE;
    };
    const auto vkCreateDebugUtilsMessenger =
        reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
    DPL_VK_MAKE(messenger_, vkCreateDebugUtilsMessenger, instance_, messenger);
    return {};
}

Status Device::choosePhysical(const Presentation& presentation) {
    uint32_t count = 0;
    DPL_VK(vkEnumeratePhysicalDevices(instance_, &count, nullptr));
    std::vector<VkPhysicalDevice> all(count);
    DPL_VK(vkEnumeratePhysicalDevices(instance_, &count, all.data()));
    all.resize(count);
    int best = 0;
    for (VkPhysicalDevice physical : all) {
        VkPhysicalDeviceProperties properties{};
        vkGetPhysicalDeviceProperties(physical, &properties);
        if (properties.apiVersion < VK_API_VERSION_1_1) continue;
        DPL_SHELL_TRY(const bool shows, hasSwapchains(physical));
        if (!shows) continue;
        const int family = familyOf(instance_, physical, presentation), rank = rankOf(properties.deviceType);
        if (family < 0 || rank <= best) continue;
        best = rank;
        handles_.physical = physical, family_ = uint32_t(family), name_ = properties.deviceName;
    }
    if (!handles_.physical)
        return Error{DPL_ERROR_UNSUPPORTED, "no Vulkan 1.1 device here can draw, compute and show pictures in a window"};
    return {};
}

Status Device::makeDevice() {
    VkPhysicalDeviceFeatures has{};
    vkGetPhysicalDeviceFeatures(physical(), &has);
    enabled_.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    // What dplGetVulkanRequirement lists as optional, except multiview: a window shows one view.
    enabled_.features.sampleRateShading = has.sampleRateShading;
    enabled_.features.shaderStorageImageExtendedFormats = has.shaderStorageImageExtendedFormats;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    const char* swapchain = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.pNext = &enabled_;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &swapchain;
    DPL_VK_MAKE(handles_.device, vkCreateDevice, physical(), info);
    vkGetDeviceQueue(device(), family_, 0, &queue_);
    return {};
}

DplVulkanDevice Device::forDoppel() {
    DplVulkanDevice mine{};
    mine.structSize = sizeof mine;
    mine.queueFamily = family_;
    mine.instance = instance_, mine.physicalDevice = physical(), mine.device = device(), mine.queue = queue_;
    mine.enabledFeatures = &enabled_;
    mine.lockQueue = [](void* user) { static_cast<Device*>(user)->queueMutex_.lock(); };
    mine.unlockQueue = [](void* user) { static_cast<Device*>(user)->queueMutex_.unlock(); };
    mine.user = this;
    return mine;
}

Status Device::submit(const VkSubmitInfo& info, VkFence fence) {
    std::lock_guard lock(queueMutex_);
    DPL_VK(vkQueueSubmit(queue_, 1, &info, fence));
    return {};
}

VkResult Device::present(const VkPresentInfoKHR& info) {
    std::lock_guard lock(queueMutex_);
    return vkQueuePresentKHR(queue_, &info);
}

Status Device::waitIdle() {
    std::lock_guard lock(queueMutex_);
    DPL_VK(vkQueueWaitIdle(queue_));
    return {};
}

Status Device::runOnce(const std::function<void(VkCommandBuffer)>& record) {
    VkCommandPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    poolInfo.queueFamilyIndex = family_;
    VkCommandPool pool = VK_NULL_HANDLE;
    DPL_VK_MAKE(pool, vkCreateCommandPool, device(), poolInfo);
    const auto run = [&]() -> Status {
        VkCommandBufferAllocateInfo allocation{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        allocation.commandPool = pool;
        allocation.commandBufferCount = 1;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        DPL_VK(vkAllocateCommandBuffers(device(), &allocation, &commands));
        VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
        DPL_VK(vkBeginCommandBuffer(commands, &begin));
        record(commands);
        DPL_VK(vkEndCommandBuffer(commands));
        VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        info.commandBufferCount = 1;
        info.pCommandBuffers = &commands;
        DPL_SHELL_OK(submit(info, VK_NULL_HANDLE));
        return waitIdle();
    };
    Status done = run();
    vkDestroyCommandPool(device(), pool, nullptr);
    return done;
}

std::vector<std::string> Device::complaints() const {
    std::lock_guard lock(complaintsMutex_);
    return complaints_;
}

}  // namespace dpl::platform
