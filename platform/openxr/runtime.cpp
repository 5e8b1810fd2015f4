// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/runtime.h"

#include <algorithm>
#include <cstring>

#include "platform/openxr/enumerate.h"

namespace dpl::xr {
namespace {

constexpr const char* kValidation = "VK_LAYER_KHRONOS_validation";
constexpr size_t kMaxComplaints = 20;
constexpr VkQueueFlags kDrawsAndComputes = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;

Error unsupported(std::string text) {
    return {DPL_ERROR_UNSUPPORTED, std::move(text)};
}

bool hasValidationLayer() {
    uint32_t count = 0;
    vkEnumerateInstanceLayerProperties(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    vkEnumerateInstanceLayerProperties(&count, layers.data());
    return std::any_of(layers.begin(), layers.end(), [](const auto& layer) { return std::strcmp(layer.layerName, kValidation) == 0; });
}

std::string versionText(uint32_t version) {
    return std::to_string(VK_VERSION_MAJOR(version)) + "." + std::to_string(VK_VERSION_MINOR(version));
}

/** What of dplGetVulkanRequirement a device made here fulfils when it can be made at all. */
bool isKnownRequirement(const char* name) {
    return std::strstr(name, "VK_API_VERSION_1_1") || std::strstr(name, "VK_QUEUE_GRAPHICS_BIT and VK_QUEUE_COMPUTE_BIT");
}

}  // namespace

Result<std::unique_ptr<Runtime>> Runtime::create(const RuntimeOptions& options) {
    std::unique_ptr<Runtime> made(new Runtime);
    for (const auto step : {&Runtime::createInstance, &Runtime::createVulkan, &Runtime::createDevice})
        if (Status done = (made.get()->*step)(options); !done) return done.error();
    if (Status done = made->createContext(); !done) return done.error();
    return made;
}

Runtime::~Runtime() {
    dplDestroyContext(context_);
    if (device_) vkDestroyDevice(device_, nullptr);
    if (messenger_)
        reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(vulkan_, "vkDestroyDebugUtilsMessengerEXT"))(
            vulkan_, messenger_, nullptr);
    if (vulkan_) vkDestroyInstance(vulkan_, nullptr);
    if (instance_) xrDestroyInstance(instance_);
}

Error Runtime::failed(XrResult result, const char* call) const {
    char name[XR_MAX_RESULT_STRING_SIZE] = "";
    if (!instance_ || XR_FAILED(xrResultToString(instance_, result, name))) std::snprintf(name, sizeof name, "%d", int(result));
    return {DPL_ERROR_DEVICE, std::string(call) + " failed: " + name};
}

PFN_xrVoidFunction Runtime::functionNamed(const char* name) const {
    PFN_xrVoidFunction found = nullptr;
    return XR_SUCCEEDED(xrGetInstanceProcAddr(instance_, name, &found)) ? found : nullptr;
}

Status Runtime::createInstance(const RuntimeOptions& options) {
    std::vector<XrExtensionProperties> offered;
    const XrResult listed = enumerate(
        offered, XrExtensionProperties{XR_TYPE_EXTENSION_PROPERTIES},
        [](auto capacity, auto count, auto out) { return xrEnumerateInstanceExtensionProperties(nullptr, capacity, count, out); });
    if (XR_FAILED(listed))
        return unsupported("no OpenXR runtime answers (" + std::to_string(int(listed)) +
                           "); install and start one, such as Monado, or set XR_RUNTIME_JSON to its manifest");
    std::vector<const char*> wanted;
    const auto want = [&](const char* name) {
        const bool has = std::any_of(offered.begin(), offered.end(), [&](const auto& offer) {
            return std::strncmp(offer.extensionName, name, XR_MAX_EXTENSION_NAME_SIZE) == 0;
        });
        if (has) wanted.push_back(name);
        return has;
    };
    if (!want(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME))
        return unsupported("the OpenXR runtime lacks " XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME ", so it cannot show Vulkan images; update it");
    for (const char* needed : options.instanceExtensions)
        if (!want(needed)) return unsupported(std::string("the OpenXR runtime lacks ") + needed + ", which this platform needs; update it");
    extensions_.depthLayer = want(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME);
    extensions_.refreshRate = want(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME);
    extensions_.quadViews = want(XR_VARJO_QUAD_VIEWS_EXTENSION_NAME);
    extensions_.localFloor = want(XR_EXT_LOCAL_FLOOR_EXTENSION_NAME);
    extensions_.passthrough = want(XR_FB_PASSTHROUGH_EXTENSION_NAME);
    extensions_.handTracking = want(XR_EXT_HAND_TRACKING_EXTENSION_NAME);
    extensions_.bodyTracking = want(XR_FB_BODY_TRACKING_EXTENSION_NAME);

    XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
    info.next = options.instanceNext;
    std::strncpy(info.applicationInfo.applicationName, options.applicationName.c_str(), XR_MAX_APPLICATION_NAME_SIZE - 1);
    std::strncpy(info.applicationInfo.engineName, "doppel", XR_MAX_ENGINE_NAME_SIZE - 1);
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);  // a newer one would shut old runtimes out
    info.enabledExtensionCount = uint32_t(wanted.size());
    info.enabledExtensionNames = wanted.data();
    if (const XrResult result = xrCreateInstance(&info, &instance_); XR_FAILED(result)) {
        instance_ = XR_NULL_HANDLE;
        return unsupported("the OpenXR runtime made no instance (" + std::to_string(int(result)) + "); is its service running?");
    }
    XrInstanceProperties properties{XR_TYPE_INSTANCE_PROPERTIES};
    if (XR_SUCCEEDED(xrGetInstanceProperties(instance_, &properties))) {
        properties.runtimeName[XR_MAX_RUNTIME_NAME_SIZE - 1] = 0;
        name_ = properties.runtimeName;
    }
    if (auto system = findSystem(); !system) return system.error();
    return {};
}

Result<XrSystemId> Runtime::findSystem() {
    XrSystemGetInfo info{XR_TYPE_SYSTEM_GET_INFO};
    info.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    XrSystemId found = XR_NULL_SYSTEM_ID;
    const XrResult result = xrGetSystem(instance_, &info, &found);
    if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE) return Error{DPL_ERROR_NOT_FOUND, "no headset is connected; put it on or plug it in"};
    if (result == XR_ERROR_FORM_FACTOR_UNSUPPORTED) return unsupported("the OpenXR runtime has no headset, only other displays");
    if (XR_FAILED(result)) return failed(result, "xrGetSystem");
    const bool again = found == system_ && device_;
    system_ = found;
    if (!device_ || again) return found;
    // Another headset. Asking for its requirements is a duty of OpenXR; its GPU must be the one that the avatars are on.
    XrGraphicsRequirementsVulkan2KHR needs{XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR};
    const auto requirements = function<PFN_xrGetVulkanGraphicsRequirements2KHR>("xrGetVulkanGraphicsRequirements2KHR");
    const auto deviceOf = function<PFN_xrGetVulkanGraphicsDevice2KHR>("xrGetVulkanGraphicsDevice2KHR");
    if (!requirements || !deviceOf) return unsupported("the OpenXR runtime lost its functions for Vulkan; restart the program");
    if (const XrResult asked = requirements(instance_, system_, &needs); XR_FAILED(asked))
        return failed(asked, "xrGetVulkanGraphicsRequirements2KHR");
    XrVulkanGraphicsDeviceGetInfoKHR which{XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR};
    which.systemId = system_;
    which.vulkanInstance = vulkan_;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    if (const XrResult asked = deviceOf(instance_, &which, &physical); XR_FAILED(asked))
        return failed(asked, "xrGetVulkanGraphicsDevice2KHR");
    if (physical != physical_) return unsupported("the headset is now on another GPU than the program; restart the program");
    return found;
}

Status Runtime::createVulkan(const RuntimeOptions& options) {
    const auto requirements = function<PFN_xrGetVulkanGraphicsRequirements2KHR>("xrGetVulkanGraphicsRequirements2KHR");
    const auto create = function<PFN_xrCreateVulkanInstanceKHR>("xrCreateVulkanInstanceKHR");
    const auto deviceOf = function<PFN_xrGetVulkanGraphicsDevice2KHR>("xrGetVulkanGraphicsDevice2KHR");
    if (!requirements || !create || !deviceOf)
        return unsupported("the OpenXR runtime offers " XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME " but not its functions; update it");
    XrGraphicsRequirementsVulkan2KHR needs{XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR};
    if (const XrResult result = requirements(instance_, system_, &needs); XR_FAILED(result))
        return failed(result, "xrGetVulkanGraphicsRequirements2KHR");
    uint32_t available = VK_API_VERSION_1_0;
    vkEnumerateInstanceVersion(&available);
    const uint32_t least = VK_MAKE_VERSION(uint32_t(XR_VERSION_MAJOR(needs.minApiVersionSupported)),
                                           uint32_t(XR_VERSION_MINOR(needs.minApiVersionSupported)), 0);
    const uint32_t version = std::max(least, uint32_t(VK_API_VERSION_1_1));
    if (version > available)
        return unsupported("Vulkan " + versionText(version) + " is needed and the machine's loader has " + versionText(available));

    const bool validation = options.validate;
    if (validation && !hasValidationLayer())
        return unsupported(std::string(kValidation) + " is not installed (Debian: vulkan-validationlayers)");
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = options.applicationName.c_str();
    application.pEngineName = "doppel";
    application.apiVersion = version;
    const VkValidationFeatureEnableEXT synchronisation = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronisation;
    const char* extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    if (validation) {
        info.pNext = &features;
        info.enabledLayerCount = 1, info.ppEnabledLayerNames = &kValidation;
        info.enabledExtensionCount = 2, info.ppEnabledExtensionNames = extensions;
    }
    XrVulkanInstanceCreateInfoKHR through{XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR};
    through.systemId = system_;
    through.pfnGetInstanceProcAddr = vkGetInstanceProcAddr;
    through.vulkanCreateInfo = &info;
    VkResult vulkanResult = VK_SUCCESS;
    VkInstance instance = VK_NULL_HANDLE;
    const XrResult result = create(instance_, &through, &instance, &vulkanResult);
    if (XR_FAILED(result)) return failed(result, "xrCreateVulkanInstanceKHR");
    if (vulkanResult != VK_SUCCESS || !instance)
        return unsupported("the runtime could not create a Vulkan instance (VkResult " + std::to_string(int(vulkanResult)) + ")");
    vulkan_ = instance;
    if (validation) {
        VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
        messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
        messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
        messenger.pfnUserCallback = onMessage;
        messenger.pUserData = this;
        const auto listen =
            reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(vulkan_, "vkCreateDebugUtilsMessengerEXT"));
        if (!listen || listen(vulkan_, &messenger, nullptr, &messenger_) != VK_SUCCESS)
            return unsupported("the validation layer takes no listener; install its current version");
    }
    XrVulkanGraphicsDeviceGetInfoKHR which{XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR};
    which.systemId = system_;
    which.vulkanInstance = vulkan_;
    if (const XrResult chosen = deviceOf(instance_, &which, &physical_); XR_FAILED(chosen))
        return failed(chosen, "xrGetVulkanGraphicsDevice2KHR");
    if (!physical_) return unsupported("the OpenXR runtime names no GPU");
    return {};
}

Status Runtime::createDevice(const RuntimeOptions&) {
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(physical_, &properties);
    name_ += std::string(" on ") + properties.deviceName;
    if (properties.apiVersion < VK_API_VERSION_1_1)
        return unsupported(std::string(properties.deviceName) + " has Vulkan " + versionText(properties.apiVersion) + "; 1.1 is needed");
    for (uint32_t i = 0;; ++i) {
        const auto requirement = doppel::filled<DplVulkanRequirement>(dplGetVulkanRequirement, i);
        if (!requirement) break;
        if (requirement->required && !isKnownRequirement(requirement->name))
            return unsupported(std::string("this libdoppel needs ") + requirement->name +
                               ", which the program does not know; build it anew");
    }
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, families.data());
    const auto family = std::find_if(families.begin(), families.end(),
                                     [](const auto& f) { return (f.queueFlags & kDrawsAndComputes) == kDrawsAndComputes; });
    if (family == families.end()) return unsupported(std::string(properties.deviceName) + " has no queue that draws and computes");
    family_ = uint32_t(family - families.begin());

    VkPhysicalDeviceFeatures2 has{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    VkPhysicalDeviceMultiviewFeatures hasMultiview{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    has.pNext = &hasMultiview;
    vkGetPhysicalDeviceFeatures2(physical_, &has);
    multiviewFeatures_.multiview = hasMultiview.multiview;
    enabled_.pNext = &multiviewFeatures_;
    enabled_.features.sampleRateShading = has.features.sampleRateShading;
    enabled_.features.shaderStorageImageExtendedFormats = has.features.shaderStorageImageExtendedFormats;

    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.pNext = &enabled_;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    XrVulkanDeviceCreateInfoKHR through{XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR};
    through.systemId = system_;
    through.pfnGetInstanceProcAddr = vkGetInstanceProcAddr;
    through.vulkanPhysicalDevice = physical_;
    through.vulkanCreateInfo = &info;
    const auto create = function<PFN_xrCreateVulkanDeviceKHR>("xrCreateVulkanDeviceKHR");
    if (!create) return unsupported("the OpenXR runtime lacks xrCreateVulkanDeviceKHR; update it");
    VkResult vulkanResult = VK_SUCCESS;
    VkDevice device = VK_NULL_HANDLE;
    const XrResult result = create(instance_, &through, &device, &vulkanResult);
    if (XR_FAILED(result)) return failed(result, "xrCreateVulkanDeviceKHR");
    if (vulkanResult != VK_SUCCESS || !device)
        return unsupported("the runtime could not open " + std::string(properties.deviceName) + " (VkResult " +
                           std::to_string(int(vulkanResult)) + ")");
    device_ = device;
    vkGetDeviceQueue(device_, family_, 0, &queue_);
    return {};
}

Status Runtime::createContext() {
    DplVulkanDevice mine{};
    mine.structSize = sizeof mine;
    mine.queueFamily = family_;
    mine.instance = vulkan_, mine.physicalDevice = physical_, mine.device = device_, mine.queue = queue_;
    mine.enabledFeatures = &enabled_;
    if (Status made = doppel::status(dplCreateVulkanContext(&mine, nullptr, &context_)); !made) return made;
    findMultiview();
    return {};
}

/** Asks Doppel for a composer with a view mask: some drivers draw with multiview wrongly, and Doppel knows which. */
void Runtime::findMultiview() {
    if (!multiviewFeatures_.multiview) return;
    VkAttachmentDescription colour{};
    colour.format = VK_FORMAT_R8G8B8A8_SRGB;
    colour.samples = VK_SAMPLE_COUNT_1_BIT;
    colour.loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    colour.finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    const uint32_t mask = 3;
    VkRenderPassMultiviewCreateInfo multiview{VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO};
    multiview.subpassCount = 1;
    multiview.pViewMasks = &mask;
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.pNext = &multiview;
    info.attachmentCount = 1;
    info.pAttachments = &colour;
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    DplVulkanPass pass{};
    pass.structSize = sizeof pass;
    pass.viewMask = mask;
    pass.colourFormat = colour.format;
    if (vkCreateRenderPass(device_, &info, nullptr, &pass.renderPass) != VK_SUCCESS) return;
    uint32_t composer = 0;
    multiview_ = dplCreateVulkanComposer(context_, &pass, &composer) == DPL_OK;
    if (multiview_) dplDestroyVulkanComposer(context_, composer);
    vkDestroyRenderPass(device_, pass.renderPass, nullptr);
}

Result<uint32_t> Runtime::memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const {
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    return unsupported("the GPU has no memory of the kind that an image or a buffer needs");
}

VkBool32 Runtime::onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                            const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    auto& self = *static_cast<Runtime*>(user);
    if (++self.complaintCount_ <= kMaxComplaints) self.complaints_.push_back(data->pMessage);
    return VK_FALSE;
}

}  // namespace dpl::xr
