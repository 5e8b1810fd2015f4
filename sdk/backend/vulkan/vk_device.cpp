// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/vulkan/vk_device.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <span>

#include "sdk/backend/vulkan/vk_loader.h"
#include "sdk/backend/vulkan/vk_quirks.h"
#include "sdk/core/log.h"

namespace dpl::vk {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    static_cast<Device*>(user)->validationMessages->fetch_add(1);
    log(LogLevel::Warning, "vulkan: {}", data->pMessage);
    return VK_FALSE;
}

bool hasLayer(const Functions& vk, const char* name) {
    uint32_t count = 0;
    vk.vkEnumerateInstanceLayerProperties(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    vk.vkEnumerateInstanceLayerProperties(&count, layers.data());
    return std::any_of(layers.begin(), layers.end(), [&](const auto& l) { return std::strcmp(l.layerName, name) == 0; });
}

Status createInstance(Device& d, bool validation) {
    DPL_TRY(const PFN_vkGetInstanceProcAddr getInstanceProcAddr, findVulkanLoader());
    DPL_RETURN_IF_ERROR(d.vk.loadGlobal(getInstanceProcAddr));
    uint32_t version = VK_API_VERSION_1_0;
    d.vk.vkEnumerateInstanceVersion(&version);
    if (version < VK_API_VERSION_1_1) return fail(Code::Unsupported, "the Vulkan loader is older than 1.1");
    if (validation && !hasLayer(d.vk, kValidationLayer))
        return fail(Code::NotFound, "{} is not installed (Debian: vulkan-validationlayers)", kValidationLayer);
    VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    app.pApplicationName = app.pEngineName = "doppel";
    app.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &app;
    const char* extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = enabled;
    if (validation) {
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &kValidationLayer;
        info.enabledExtensionCount = 2;
        info.ppEnabledExtensionNames = extensions;
        info.pNext = &features;
    }
    const VkResult created = d.vk.vkCreateInstance(&info, nullptr, &d.instance);
    if (created != VK_SUCCESS) d.instance = VK_NULL_HANDLE;
    if (created == VK_ERROR_INCOMPATIBLE_DRIVER) return fail(Code::Unsupported, "the Vulkan loader finds no driver");
    if (created != VK_SUCCESS) return failVk("vkCreateInstance", created);
    DPL_RETURN_IF_ERROR(d.vk.loadInstance(d.instance));
    if (!validation) return {};
    VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    messenger.pfnUserCallback = onMessage;
    messenger.pUserData = &d;
    if (!d.vk.vkCreateDebugUtilsMessengerEXT || !d.vk.vkDestroyDebugUtilsMessengerEXT)
        return fail(Code::Unsupported, "the validation layer has no VK_EXT_debug_utils");
    DPL_VK_MAKE(d.messenger, d.vk.vkCreateDebugUtilsMessengerEXT(d.instance, &messenger, nullptr, &d.messenger));
    return {};
}

DeviceKind kindOf(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return DeviceKind::Discrete;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return DeviceKind::Integrated;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return DeviceKind::Virtual;
        case VK_PHYSICAL_DEVICE_TYPE_CPU:
            return DeviceKind::Software;
        default:
            return DeviceKind::Other;
    }
}

int rank(DeviceKind kind) {
    switch (kind) {
        case DeviceKind::Discrete:
            return 0;
        case DeviceKind::Integrated:
            return 1;
        case DeviceKind::Virtual:
            return 2;
        case DeviceKind::Other:
            return 3;
        default:
            return 4;
    }
}

bool canBlend(const Functions& vk, VkPhysicalDevice physical, VkFormat format, VkFormatFeatureFlags andThen) {
    VkFormatProperties properties{};
    vk.vkGetPhysicalDeviceFormatProperties(physical, format, &properties);
    const VkFormatFeatureFlags wanted = VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT | andThen;
    return (properties.optimalTilingFeatures & wanted) == wanted;
}

struct Candidate {
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    uint32_t queueFamily = 0, timestampBits = 0;
    double nanosecondsPerTick = 0;
    DeviceInfo info;
};

std::vector<VkQueueFamilyProperties> familiesOf(const Functions& vk, VkPhysicalDevice physical) {
    uint32_t count = 0;
    vk.vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vk.vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    return families;
}

bool drawsAndComputes(const VkQueueFamilyProperties& family) {
    constexpr VkQueueFlags kWanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    return (family.queueFlags & kWanted) == kWanted;
}

bool isRecent(const Functions& vk, VkPhysicalDevice physical) {
    VkPhysicalDeviceProperties properties{};
    vk.vkGetPhysicalDeviceProperties(physical, &properties);
    return properties.apiVersion >= VK_API_VERSION_1_1;
}

/** The largest heap of the device's own memory. */
uint64_t deviceMemoryBytes(const Functions& vk, VkPhysicalDevice physical) {
    VkPhysicalDeviceMemoryProperties memory{};
    vk.vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    uint64_t largest = 0;
    for (const VkMemoryHeap& heap : std::span(memory.memoryHeaps, memory.memoryHeapCount))
        if (heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) largest = std::max<uint64_t>(largest, heap.size);
    return largest;
}

/** Describes what the device can do, and the queue family. The device has Vulkan 1.1. */
void describe(const Functions& vk, VkPhysicalDevice physical, uint32_t queueFamily, Candidate& out) {
    VkPhysicalDeviceProperties properties{};
    vk.vkGetPhysicalDeviceProperties(physical, &properties);
    const VkQueueFamilyProperties family = familiesOf(vk, physical)[queueFamily];

    VkPhysicalDeviceMultiviewFeatures multiview{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    features.pNext = &multiview;
    vk.vkGetPhysicalDeviceFeatures2(physical, &features);

    VkPhysicalDeviceIDProperties ids{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
    VkPhysicalDeviceProperties2 properties2{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    properties2.pNext = &ids;
    VkPhysicalDeviceSubgroupProperties subgroups{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    ids.pNext = &subgroups;
    vk.vkGetPhysicalDeviceProperties2(physical, &properties2);
    for (uint8_t byte : ids.deviceUUID)
        out.info.identity += "0123456789abcdef"[byte >> 4], out.info.identity += "0123456789abcdef"[byte & 15];
    for (uint8_t byte : ids.driverUUID)
        out.info.identity += "0123456789abcdef"[byte >> 4], out.info.identity += "0123456789abcdef"[byte & 15];
    out.info.identity += formatText("-{}", properties.driverVersion);

    out.physical = physical;
    out.queueFamily = queueFamily;
    out.timestampBits = family.timestampValidBits;
    out.nanosecondsPerTick = double(properties.limits.timestampPeriod);
    out.info.name = properties.deviceName;
    out.info.kind = kindOf(properties.deviceType);
    out.info.maxBindingBytes = properties.limits.maxStorageBufferRange;
    out.info.memoryBytes = deviceMemoryBytes(vk, physical);
    out.info.maxTargetPx =
        std::min({properties.limits.maxImageDimension2D, properties.limits.maxFramebufferWidth, properties.limits.maxFramebufferHeight});
    out.info.maxGroups = properties.limits.maxComputeWorkGroupCount[0];
    out.info.maxStorageBuffers =
        std::min(properties.limits.maxPerStageDescriptorStorageBuffers, properties.limits.maxDescriptorSetStorageBuffers);
    out.info.maxSharedBytes = properties.limits.maxComputeSharedMemorySize;
    out.info.multiview = multiview.multiview == VK_TRUE;
    out.info.halfDepth = !canBlend(vk, physical, VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_FEATURE_TRANSFER_SRC_BIT);
    out.info.timestamps = family.timestampValidBits > 0;
    out.info.shuffle = subgroups.subgroupSize >= 8 && subgroups.subgroupSize <= 64 &&
                       (subgroups.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) &&
                       (subgroups.supportedOperations & VK_SUBGROUP_FEATURE_SHUFFLE_BIT);
    out.info.typedFormats = features.features.shaderStorageImageExtendedFormats &&
                            properties.limits.maxTexelBufferElements >= properties.limits.maxStorageBufferRange / 4;
    out.info.fourSamples = features.features.sampleRateShading && properties.limits.standardSampleLocations &&
                           (properties.limits.framebufferColorSampleCounts & VK_SAMPLE_COUNT_4_BIT);
}

std::vector<Candidate> candidates(const Functions& vk, VkInstance instance) {
    uint32_t count = 0;
    vk.vkEnumeratePhysicalDevices(instance, &count, nullptr);
    std::vector<VkPhysicalDevice> all(count);
    vk.vkEnumeratePhysicalDevices(instance, &count, all.data());
    std::vector<Candidate> list;
    for (VkPhysicalDevice physical : all) {
        if (!isRecent(vk, physical)) continue;
        const std::vector<VkQueueFamilyProperties> families = familiesOf(vk, physical);
        const auto family = std::find_if(families.begin(), families.end(), drawsAndComputes);
        if (family != families.end()) describe(vk, physical, uint32_t(family - families.begin()), list.emplace_back());
    }
    std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return rank(a.info.kind) < rank(b.info.kind); });
    return list;
}

void take(Device& d, const Candidate& chosen) {
    d.physical = chosen.physical;
    d.queueFamily = chosen.queueFamily;
    d.timestampBits = chosen.timestampBits;
    d.nanosecondsPerTick = chosen.nanosecondsPerTick;
    d.info = chosen.info;
    d.depthSumFormat = d.info.halfDepth ? VK_FORMAT_R16G16_SFLOAT : VK_FORMAT_R32G32_SFLOAT;
    d.vk.vkGetPhysicalDeviceMemoryProperties(d.physical, &d.memory);
}

/** The features that an app enabled, of those that Doppel uses. */
struct EnabledFeatures {
    bool multiview = false, sampleRateShading = false, storageImageExtendedFormats = false;

    explicit EnabledFeatures(const VkPhysicalDeviceFeatures2* chain) {
        if (!chain) return;
        sampleRateShading = chain->features.sampleRateShading;
        storageImageExtendedFormats = chain->features.shaderStorageImageExtendedFormats;
        for (auto* link = static_cast<const VkBaseInStructure*>(chain->pNext); link; link = link->pNext) {
            if (link->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES)
                multiview = reinterpret_cast<const VkPhysicalDeviceMultiviewFeatures*>(link)->multiview;
            if (link->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES)
                multiview = reinterpret_cast<const VkPhysicalDeviceVulkan11Features*>(link)->multiview;
        }
    }
};

// With its last instance a process unloads the driver. NVIDIA's cannot be loaded again and again: after about thirty times the thread-local
// storage of the process is used up, and "the Vulkan loader finds no driver". So the first instance stays open.
bool staysOpen(VkInstance instance) {
    static std::atomic<VkInstance> first{VK_NULL_HANDLE};
    VkInstance none = VK_NULL_HANDLE;
    return first.compare_exchange_strong(none, instance);
}

}  // namespace

Error failVk(std::string_view what, VkResult result) {
    what = what.substr(0, what.find('('));
    what = what.substr(what.find_last_of(".>") + 1);  // without '.' and '>': npos + 1 == 0, the whole text
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        case VK_ERROR_OUT_OF_POOL_MEMORY:
        case VK_ERROR_FRAGMENTED_POOL:
        case VK_ERROR_TOO_MANY_OBJECTS:
        case VK_ERROR_MEMORY_MAP_FAILED:
            return fail(Code::OutOfMemory, "there is not enough memory for Vulkan (error {} from {}); free some and call again",
                        int(result), what);
        case VK_ERROR_DEVICE_LOST:
            return fail(Code::Device, "the graphics device was lost (error {} from {}); call dplRebuildVulkan", int(result), what);
        case VK_TIMEOUT:
            return fail(Code::Device, "the graphics device does not finish ({} timed out); call dplRebuildVulkan", what);
        default:
            return fail(Code::Device, "Vulkan error {} from {}", int(result), what);
    }
}

Device::~Device() {
    if (lent) return;
    // openDevice may have failed before the functions were loaded.
    if (device && vk.vkDestroyDevice) vk.vkDestroyDevice(device, nullptr);
    if (messenger) vk.vkDestroyDebugUtilsMessengerEXT(instance, messenger, nullptr);
    if (instance && vk.vkDestroyInstance && !staysOpen(instance)) vk.vkDestroyInstance(instance, nullptr);
}

Result<std::unique_ptr<Device>> openDevice(const DeviceRequest& request) {
    auto d = std::make_unique<Device>();
    d->validationMessages = request.validationMessages;
    DPL_RETURN_IF_ERROR(createInstance(*d, request.validationMessages != nullptr));
    const std::vector<Candidate> list = candidates(d->vk, d->instance);
    if (list.empty()) return fail(Code::Unsupported, "no Vulkan 1.1 device with graphics and compute; use the software renderer");
    const Candidate* chosen = nullptr;
    for (const Candidate& c : list) {
        if (c.info.isSoftware() && !request.allowSoftware) continue;
        if (c.info.name.find(request.name) == std::string::npos) continue;
        chosen = &c;
        break;
    }
    if (!chosen)
        return fail(Code::Unsupported, "no Vulkan device fits (wanted '{}', software devices {}); the best here is {}", request.name,
                    request.allowSoftware ? "allowed" : "not allowed", list.front().info.name);
    take(*d, *chosen);
    if (request.quirks) applyQuirks(d->info);
    if (request.narrow) request.narrow(d->info);

    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = d->queueFamily;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkPhysicalDeviceMultiviewFeatures multiview{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    multiview.multiview = d->info.multiview;
    VkPhysicalDeviceFeatures features{};
    features.sampleRateShading = d->info.fourSamples;
    features.shaderStorageImageExtendedFormats = d->info.texels;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.pEnabledFeatures = &features;
    info.pNext = &multiview;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    DPL_VK_MAKE(d->device, d->vk.vkCreateDevice(d->physical, &info, nullptr, &d->device));
    DPL_RETURN_IF_ERROR(d->vk.loadDevice(d->device));
    d->vk.vkGetDeviceQueue(d->device, d->queueFamily, 0, &d->queue);
    return d;
}

Result<std::unique_ptr<Device>> borrowDevice(const AppDevice& app) {
    auto d = std::make_unique<Device>();
    d->lent = true;
    if (!app.instance || !app.physical || !app.device || !app.queue)
        return fail(Code::InvalidArgument, "the {} of the app's device is null",
                    !app.instance   ? "instance"
                    : !app.physical ? "physical device"
                    : !app.device   ? "device"
                                    : "queue");
    if (!app.lockQueue != !app.unlockQueue) return fail(Code::InvalidArgument, "lockQueue and unlockQueue must both be set, or neither");
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = app.getInstanceProcAddr;
    if (!getInstanceProcAddr) {
        DPL_TRY(getInstanceProcAddr, findVulkanLoader());
    }
    d->vk.vkGetInstanceProcAddr = getInstanceProcAddr;
    d->instance = app.instance;
    DPL_RETURN_IF_ERROR(d->vk.loadInstance(app.instance));
    if (!isRecent(d->vk, app.physical)) return fail(Code::Unsupported, "the app's device is older than Vulkan 1.1");
    const std::vector<VkQueueFamilyProperties> families = familiesOf(d->vk, app.physical);
    if (app.queueFamily >= families.size())
        return fail(Code::InvalidArgument, "there is no queue family {}; the device has {}", app.queueFamily, families.size());
    if (!drawsAndComputes(families[app.queueFamily]))
        return fail(Code::Unsupported,
                    "queue family {} cannot draw and compute; choose one with VK_QUEUE_GRAPHICS_BIT and "
                    "VK_QUEUE_COMPUTE_BIT",
                    app.queueFamily);
    Candidate chosen;
    describe(d->vk, app.physical, app.queueFamily, chosen);
    const EnabledFeatures enabled(app.enabled);
    take(*d, chosen);
    d->info.multiview &= enabled.multiview;
    d->info.fourSamples &= enabled.sampleRateShading;
    d->info.typedFormats &= enabled.storageImageExtendedFormats;
    applyQuirks(d->info);
    d->info.texels &= d->info.typedFormats;
    d->device = app.device;
    DPL_RETURN_IF_ERROR(d->vk.loadDevice(app.device));
    d->queue = app.queue;
    d->lockQueue = app.lockQueue, d->unlockQueue = app.unlockQueue, d->user = app.user;
    if (app.allocator) {
        d->appAllocator = *app.allocator;
        d->allocator = &d->appAllocator;
    }
    return d;
}

}  // namespace dpl::vk

namespace dpl {

Result<std::vector<DeviceInfo>> listVulkanDevices() {
    vk::Device d;
    DPL_RETURN_IF_ERROR(vk::createInstance(d, false));
    std::vector<DeviceInfo> list;
    for (const auto& c : vk::candidates(d.vk, d.instance)) list.push_back(c.info);
    return list;
}

}  // namespace dpl
