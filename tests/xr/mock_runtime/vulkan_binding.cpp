// SPDX-License-Identifier: Apache-2.0
// XR_KHR_vulkan_enable2: makes the caller's Vulkan instance and device, and listens to the validation layer.
#include <cstring>

#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"

namespace dpl::mockxr {
namespace {

constexpr const char* kValidation = "VK_LAYER_KHRONOS_validation";

template <class F>
F vulkanFunction(VkInstance instance, const char* name) {
    return reinterpret_cast<F>(runtime().instance->vulkanProc(instance, name));
}

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
    // The caller destroys its instance, and cannot know of the messenger below.
    const bool mine = data->objectCount > 1 && data->pObjects[1].objectType == VK_OBJECT_TYPE_DEBUG_UTILS_MESSENGER_EXT;
    if (mine && data->pMessageIdName && std::strcmp(data->pMessageIdName, "VUID-vkDestroyInstance-instance-00629") == 0) return VK_FALSE;
    const std::lock_guard lock(runtime().mutex);
    runtime().vulkanMessages.push_back(data->pMessage);
    return VK_FALSE;
}

bool validationInstalled() {
    const auto list = vulkanFunction<PFN_vkEnumerateInstanceLayerProperties>(VK_NULL_HANDLE, "vkEnumerateInstanceLayerProperties");
    uint32_t count = 0;
    list(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    list(&count, layers.data());
    for (const VkLayerProperties& layer : layers)
        if (std::strcmp(layer.layerName, kValidation) == 0) return true;
    return false;
}

bool has(const std::vector<const char*>& names, const char* name) {
    for (const char* n : names)
        if (std::strcmp(n, name) == 0) return true;
    return false;
}

/** The caller's instance with the validation layer, whose messages come here from the first call to the last. */
VkResult createValidated(const VkInstanceCreateInfo& wanted, const VkAllocationCallbacks* allocator, VkInstance* instance) {
    std::vector<const char*> layers(wanted.ppEnabledLayerNames, wanted.ppEnabledLayerNames + wanted.enabledLayerCount);
    std::vector<const char*> extensions(wanted.ppEnabledExtensionNames, wanted.ppEnabledExtensionNames + wanted.enabledExtensionCount);
    VkInstanceCreateInfo info = wanted;
    const VkValidationFeatureEnableEXT synchronisation = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, wanted.pNext, 1, &synchronisation, 0, nullptr};
    if (!has(layers, kValidation)) {
        layers.push_back(kValidation);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
        info.pNext = &features;
    }
    if (!has(extensions, VK_EXT_DEBUG_UTILS_EXTENSION_NAME)) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT, info.pNext};
    messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = onMessage;
    info.pNext = &messenger;
    info.enabledLayerCount = uint32_t(layers.size()), info.ppEnabledLayerNames = layers.data();
    info.enabledExtensionCount = uint32_t(extensions.size()), info.ppEnabledExtensionNames = extensions.data();
    return vulkanFunction<PFN_vkCreateInstance>(VK_NULL_HANDLE, "vkCreateInstance")(&info, allocator, instance);
}

/** The messenger of the create info hears only vkCreateInstance and vkDestroyInstance; this one hears what comes between. */
void listen(VkInstance instance) {
    VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = onMessage;
    VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
    vulkanFunction<PFN_vkCreateDebugUtilsMessengerEXT>(instance, "vkCreateDebugUtilsMessengerEXT")(instance, &info, nullptr, &messenger);
}

}  // namespace

namespace entry {

DPL_MOCKXR_ENTRY(xrGetVulkanGraphicsRequirements2KHR)(XrInstance, XrSystemId system, XrGraphicsRequirementsVulkanKHR* requirements) {
    DPL_MOCKXR_TRY(checkSystem(system));
    DPL_MOCKXR_TRY(checkStructure(requirements, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR, "graphicsRequirements"));
    requirements->minApiVersionSupported = XR_MAKE_VERSION(1, 1, 0);
    requirements->maxApiVersionSupported = XR_MAKE_VERSION(1, 3, 0);
    runtime().instance->requirementsAsked = true;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrCreateVulkanInstanceKHR)(XrInstance, const XrVulkanInstanceCreateInfoKHR* info, VkInstance* instance, VkResult* result) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR, "createInfo"));
    DPL_MOCKXR_TRY(checkSystem(info->systemId));
    if (info->createFlags != 0 || !info->pfnGetInstanceProcAddr || !info->vulkanCreateInfo)
        return violated(XR_ERROR_VALIDATION_FAILURE, "createInfo lacks a function or a structure, or has flags");
    if (!r.instance->requirementsAsked)
        return violated(XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING, "xrGetVulkanGraphicsRequirements2KHR was not called before");
    r.instance->vulkanProc = info->pfnGetInstanceProcAddr;
    r.vulkanValidated = r.settings.validation && validationInstalled();
    if (r.vulkanValidated)
        *result = createValidated(*info->vulkanCreateInfo, info->vulkanAllocator, instance);
    else
        *result = vulkanFunction<PFN_vkCreateInstance>(VK_NULL_HANDLE, "vkCreateInstance")(info->vulkanCreateInfo, info->vulkanAllocator,
                                                                                           instance);
    if (*result != VK_SUCCESS) return XR_SUCCESS;  // the caller looks at both results
    r.instance->vulkanInstance = *instance;
    if (r.vulkanValidated) listen(*instance);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrGetVulkanGraphicsDevice2KHR)(XrInstance, const XrVulkanGraphicsDeviceGetInfoKHR* info, VkPhysicalDevice* device) {
    Instance& i = *runtime().instance;
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR, "getInfo"));
    DPL_MOCKXR_TRY(checkSystem(info->systemId));
    if (!i.vulkanInstance || info->vulkanInstance != i.vulkanInstance)
        return violated(XR_ERROR_VALIDATION_FAILURE, "vulkanInstance is not the one that xrCreateVulkanInstanceKHR made");
    uint32_t count = 1;
    vulkanFunction<PFN_vkEnumeratePhysicalDevices>(i.vulkanInstance, "vkEnumeratePhysicalDevices")(i.vulkanInstance, &count, device);
    if (count == 0) return XR_ERROR_RUNTIME_FAILURE;
    i.physicalDevice = *device;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrCreateVulkanDeviceKHR)(XrInstance, const XrVulkanDeviceCreateInfoKHR* info, VkDevice* device, VkResult* result) {
    Instance& i = *runtime().instance;
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR, "createInfo"));
    DPL_MOCKXR_TRY(checkSystem(info->systemId));
    if (info->createFlags != 0 || !info->pfnGetInstanceProcAddr || !info->vulkanCreateInfo)
        return violated(XR_ERROR_VALIDATION_FAILURE, "createInfo lacks a function or a structure, or has flags");
    if (!i.physicalDevice || info->vulkanPhysicalDevice != i.physicalDevice)
        return violated(XR_ERROR_VALIDATION_FAILURE, "vulkanPhysicalDevice is not the one that xrGetVulkanGraphicsDevice2KHR gave");
    *result = vulkanFunction<PFN_vkCreateDevice>(i.vulkanInstance, "vkCreateDevice")(i.physicalDevice, info->vulkanCreateInfo,
                                                                                     info->vulkanAllocator, device);
    if (*result != VK_SUCCESS) return XR_SUCCESS;
    i.device = *device;
    i.queueFamilies.clear();
    for (uint32_t q = 0; q < info->vulkanCreateInfo->queueCreateInfoCount; ++q)
        i.queueFamilies.push_back(info->vulkanCreateInfo->pQueueCreateInfos[q].queueFamilyIndex);
    return XR_SUCCESS;
}

}  // namespace entry
}  // namespace dpl::mockxr
