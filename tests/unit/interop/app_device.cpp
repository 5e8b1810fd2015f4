// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/interop/app_device.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace dpl::test {

void must(VkResult result, const char* call) {
    if (result == VK_SUCCESS) return;
    std::fprintf(stderr, "%s failed with %d\n", call, int(result));
    std::abort();
}

namespace {

VkImageAspectFlags aspectsOf(VkFormat format) {
    switch (format) {
        case VK_FORMAT_D16_UNORM:
        case VK_FORMAT_D32_SFLOAT:
            return VK_IMAGE_ASPECT_DEPTH_BIT;
        case VK_FORMAT_D24_UNORM_S8_UINT:
            return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
        default:
            return VK_IMAGE_ASPECT_COLOR_BIT;
    }
}

constexpr const char* kValidation = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    static_cast<AppDevice*>(user)->messages.push_back(data->pMessage);
    return VK_FALSE;
}

bool hasValidation() {
    uint32_t count = 0;
    vkEnumerateInstanceLayerProperties(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    vkEnumerateInstanceLayerProperties(&count, layers.data());
    for (const VkLayerProperties& layer : layers)
        if (std::strcmp(layer.layerName, kValidation) == 0) return true;
    return false;
}

template <class F>
F instanceFunction(VkInstance instance, const char* name) {
    return reinterpret_cast<F>(vkGetInstanceProcAddr(instance, name));
}

}  // namespace

uint32_t bytesPerPixel(VkFormat format) {
    return format == VK_FORMAT_R16G16B16A16_SFLOAT ? 8 : 4;
}

std::unique_ptr<AppDevice> AppDevice::open(const Options& options, std::string& why) {
    std::unique_ptr<AppDevice> app(new AppDevice);
    if (!app->openInstance(options, why) || !app->openDevice(options, why)) return nullptr;
    return app;
}

bool AppDevice::openInstance(const Options& options, std::string& why) {
    // Stays open, so that the driver stays loaded: NVIDIA's cannot be loaded more than about thirty times.
    static const VkInstance kept = [] {
        const VkInstanceCreateInfo plain{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
        VkInstance made = VK_NULL_HANDLE;
        return vkCreateInstance(&plain, nullptr, &made) == VK_SUCCESS ? made : VK_NULL_HANDLE;
    }();
    (void)kept;
    validated = options.validation && hasValidation();
    const VkValidationFeatureEnableEXT synchronisation = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronisation;
    const char* extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = options.dynamicRendering ? VK_API_VERSION_1_3 : options.timeline ? VK_API_VERSION_1_2 : VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    if (validated) {
        info.pNext = &features;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &kValidation;
        info.enabledExtensionCount = 2;
        info.ppEnabledExtensionNames = extensions;
    }
    if (const VkResult made = vkCreateInstance(&info, nullptr, &instance); made != VK_SUCCESS) {
        why = "vkCreateInstance failed with " + std::to_string(int(made));
        return false;
    }
    if (!validated) return true;
    VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = onMessage;
    messenger.pUserData = this;
    MUST(instanceFunction<PFN_vkCreateDebugUtilsMessengerEXT>(instance, "vkCreateDebugUtilsMessengerEXT")(instance, &messenger, nullptr,
                                                                                                          &messenger_));
    return true;
}

bool AppDevice::openDevice(const Options& options, std::string& why) {
    uint32_t count = 1;
    vkEnumeratePhysicalDevices(instance, &count, &physical);
    if (count == 0) {
        why = "there is no Vulkan device";
        return false;
    }
    multiview_.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES;
    dynamic_.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES;
    VkPhysicalDeviceFeatures2 has{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    has.pNext = &multiview_;
    timeline_.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES;
    if (options.dynamicRendering) multiview_.pNext = &dynamic_;
    if (options.timeline) multiview_.pNext = &timeline_;
    vkGetPhysicalDeviceFeatures2(physical, &has);
    if ((options.multiview && !multiview_.multiview) || (options.dynamicRendering && !dynamic_.dynamicRendering) ||
        (options.timeline && !timeline_.timelineSemaphore)) {
        why = "the device lacks a feature that the test needs";
        return false;
    }
    multiview_.multiview = options.multiview, multiview_.multiviewGeometryShader = multiview_.multiviewTessellationShader = VK_FALSE;
    enabled.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    enabled.pNext = &multiview_;
    enabled.features.sampleRateShading = has.features.sampleRateShading;
    enabled.features.shaderStorageImageExtendedFormats = has.features.shaderStorageImageExtendedFormats;
    const float priority = 1;
    VkDeviceQueueCreateInfo queueInfo{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queueInfo.queueFamilyIndex = family;
    queueInfo.queueCount = 1;
    queueInfo.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.pNext = &enabled;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queueInfo;
    MUST(vkCreateDevice(physical, &info, nullptr, &device));
    vkGetDeviceQueue(device, family, 0, &queue);
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = family;
    MUST(vkCreateCommandPool(device, &pool, nullptr, &pool_));
    VkCommandBufferAllocateInfo buffers{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    buffers.commandPool = pool_;
    buffers.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    buffers.commandBufferCount = kSlots;
    MUST(vkAllocateCommandBuffers(device, &buffers, commands_));
    VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    fence.flags = VK_FENCE_CREATE_SIGNALED_BIT;
    for (VkFence& f : fences_) MUST(vkCreateFence(device, &fence, nullptr, &f));
    return true;
}

AppDevice::~AppDevice() {
    if (device) {
        vkDeviceWaitIdle(device);
        staging(0);
        for (VkFence fence : fences_) vkDestroyFence(device, fence, nullptr);
        vkDestroyCommandPool(device, pool_, nullptr);
        vkDestroyDevice(device, nullptr);
    }
    if (messenger_)
        instanceFunction<PFN_vkDestroyDebugUtilsMessengerEXT>(instance, "vkDestroyDebugUtilsMessengerEXT")(instance, messenger_, nullptr);
    if (instance) vkDestroyInstance(instance, nullptr);
}

uint32_t AppDevice::memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const {
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    std::abort();
}

AppBuffer AppDevice::makeBufferIn(VkMemoryPropertyFlags memory, VkDeviceSize bytes, VkBufferUsageFlags usage) {
    AppBuffer made;
    made.bytes = bytes;
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = usage;
    MUST(vkCreateBuffer(device, &info, nullptr, &made.buffer));
    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(device, made.buffer, &needs);
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = memoryType(needs.memoryTypeBits, memory);
    MUST(vkAllocateMemory(device, &allocation, nullptr, &made.memory));
    MUST(vkBindBufferMemory(device, made.buffer, made.memory, 0));
    return made;
}

AppBuffer AppDevice::makeBuffer(VkDeviceSize bytes, VkBufferUsageFlags usage) {
    AppBuffer made = makeBufferIn(VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, bytes, usage);
    MUST(vkMapMemory(device, made.memory, 0, VK_WHOLE_SIZE, 0, reinterpret_cast<void**>(&made.mapped)));
    return made;
}

AppBuffer AppDevice::makeLocalBuffer(VkDeviceSize bytes, VkBufferUsageFlags usage) {
    return makeBufferIn(VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, bytes, usage);
}

double AppDevice::clockTickNs() const {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    VkPhysicalDeviceProperties about{};
    vkGetPhysicalDeviceProperties(physical, &about);
    return families[family].timestampValidBits > 0 ? double(about.limits.timestampPeriod) : 0;
}

void AppDevice::destroy(AppBuffer& buffer) {
    vkDestroyBuffer(device, buffer.buffer, nullptr);
    vkFreeMemory(device, buffer.memory, nullptr);
    buffer = {};
}

void AppDevice::staging(VkDeviceSize bytes) {
    destroy(staging_);
    if (bytes > 0) staging_ = makeBuffer(bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
}

void AppDevice::makeImage(AppImage& image, VkImageUsageFlags usage) {
    image.aspects = aspectsOf(image.format);
    const VkImageAspectFlags aspect = image.aspects & ~VkImageAspectFlags(VK_IMAGE_ASPECT_STENCIL_BIT);
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = image.format;
    info.extent = {image.width, image.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = image.layers;
    info.samples = VkSampleCountFlagBits(image.samples);
    info.usage = usage;
    MUST(vkCreateImage(device, &info, nullptr, &image.image));
    VkMemoryRequirements needs{};
    vkGetImageMemoryRequirements(device, image.image, &needs);
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = memoryType(needs.memoryTypeBits, 0);
    MUST(vkAllocateMemory(device, &allocation, nullptr, &image.memory));
    MUST(vkBindImageMemory(device, image.image, image.memory, 0));
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image.image;
    view.format = image.format;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
    view.subresourceRange = {aspect, 0, 1, 0, image.layers};
    MUST(vkCreateImageView(device, &view, nullptr, &image.view));
    for (uint32_t layer = 0; layer < image.layers; ++layer) {
        view.viewType = VK_IMAGE_VIEW_TYPE_2D;
        view.subresourceRange = {aspect, 0, 1, layer, 1};
        MUST(vkCreateImageView(device, &view, nullptr, &image.layerViews.emplace_back()));
    }
}

AppImage AppDevice::makeTarget(VkFormat format, uint32_t width, uint32_t height, uint32_t layers, uint32_t samples) {
    AppImage image;
    image.format = format, image.width = width, image.height = height, image.layers = layers, image.samples = samples;
    makeImage(image, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                         VK_IMAGE_USAGE_SAMPLED_BIT);
    const VkCommandBuffer commands = begin(kUploadSlot);
    barrier(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    submit(kUploadSlot);
    return image;
}

AppImage AppDevice::makeDepthTarget(VkFormat format, uint32_t width, uint32_t height, uint32_t layers, uint32_t samples) {
    AppImage image;
    image.format = format, image.width = width, image.height = height, image.layers = layers, image.samples = samples;
    makeImage(image, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    const VkCommandBuffer commands = begin(kUploadSlot);
    barrier(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    submit(kUploadSlot);
    return image;
}

bool AppDevice::isDepthTarget(VkFormat format) const {
    constexpr VkFormatFeatureFlags kWanted = VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
    VkFormatProperties properties{};
    vkGetPhysicalDeviceFormatProperties(physical, format, &properties);
    return (properties.optimalTilingFeatures & kWanted) == kWanted;
}

AppImage AppDevice::makeDepth(VkFormat format, uint32_t width, uint32_t height, std::span<const std::vector<float>> values) {
    AppImage image;
    image.format = format, image.width = width, image.height = height, image.layers = uint32_t(values.size());
    makeImage(image, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    waitAll();
    const size_t pixels = size_t(width) * height, bytes = format == VK_FORMAT_D16_UNORM ? 2 : 4;
    staging(values.size() * pixels * bytes);
    auto* to = static_cast<uint8_t*>(staging_.mapped);
    for (const std::vector<float>& layer : values)
        for (const float value : layer) {
            const auto code = uint16_t(value * 65535 + 0.5f);
            std::memcpy(to, bytes == 2 ? static_cast<const void*>(&code) : &value, bytes);
            to += bytes;
        }
    const VkCommandBuffer commands = begin(kUploadSlot);
    barrier(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, image.layers};
    region.imageExtent = {width, height, 1};
    vkCmdCopyBufferToImage(commands, staging_.buffer, image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL);
    submit(kUploadSlot);
    return image;
}

AppImage AppDevice::makeFourSampleDepth(uint32_t width, uint32_t height, float value) {
    AppImage image;
    image.format = VK_FORMAT_D32_SFLOAT, image.width = width, image.height = height, image.samples = 4;
    makeImage(image, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    const VkCommandBuffer commands = begin(kUploadSlot);
    barrier(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    const VkClearDepthStencilValue cleared{value, 0};
    const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1};
    vkCmdClearDepthStencilImage(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &cleared, 1, &whole);
    barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL);
    submit(kUploadSlot);
    return image;
}

void AppDevice::destroy(AppImage& image) {
    for (VkImageView view : image.layerViews) vkDestroyImageView(device, view, nullptr);
    vkDestroyImageView(device, image.view, nullptr);
    vkDestroyImage(device, image.image, nullptr);
    vkFreeMemory(device, image.memory, nullptr);
    image = {};
}

VkRenderPass AppDevice::makePass(VkFormat format, uint32_t samples, uint32_t viewMask, VkFormat depthFormat) {
    VkAttachmentDescription attachments[2]{};
    const VkAttachmentReference references[2] = {{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
                                                 {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL}};
    for (uint32_t i = 0; i < 2; ++i) {
        attachments[i].format = i == 0 ? format : depthFormat;
        attachments[i].samples = VkSampleCountFlagBits(samples);
        attachments[i].loadOp = attachments[i].stencilLoadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
        attachments[i].storeOp = attachments[i].stencilStoreOp = VK_ATTACHMENT_STORE_OP_STORE;
        attachments[i].initialLayout = attachments[i].finalLayout = references[i].layout;
    }
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &references[0];
    if (depthFormat != VK_FORMAT_UNDEFINED) subpass.pDepthStencilAttachment = &references[1];
    VkRenderPassMultiviewCreateInfo views{VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO};
    views.subpassCount = 1;
    views.pViewMasks = &viewMask;
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    if (viewMask) info.pNext = &views;
    info.attachmentCount = depthFormat == VK_FORMAT_UNDEFINED ? 1 : 2;
    info.subpassCount = 1;
    info.pAttachments = attachments;
    info.pSubpasses = &subpass;
    VkRenderPass pass = VK_NULL_HANDLE;
    MUST(vkCreateRenderPass(device, &info, nullptr, &pass));
    return pass;
}

VkFramebuffer AppDevice::makeFramebuffer(VkRenderPass pass, std::initializer_list<VkImageView> views, uint32_t width, uint32_t height) {
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    info.renderPass = pass;
    info.attachmentCount = uint32_t(views.size());
    info.pAttachments = views.begin();
    info.width = width;
    info.height = height;
    info.layers = 1;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    MUST(vkCreateFramebuffer(device, &info, nullptr, &framebuffer));
    return framebuffer;
}

void AppDevice::barrier(VkCommandBuffer commands, const AppImage& image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier change{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    change.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    change.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    change.oldLayout = from;
    change.newLayout = to;
    change.srcQueueFamilyIndex = change.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    change.image = image.image;
    change.subresourceRange = {image.aspects, 0, 1, 0, image.layers};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1,
                         &change);
}

void AppDevice::upload(const AppImage& image, uint32_t layer, std::span<const uint8_t> bytes) {
    waitAll();
    staging(bytes.size());
    std::memcpy(staging_.mapped, bytes.data(), bytes.size());
    const VkCommandBuffer commands = begin(kUploadSlot);
    barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, layer, 1};
    region.imageExtent = {image.width, image.height, 1};
    vkCmdCopyBufferToImage(commands, staging_.buffer, image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    submit(kUploadSlot);
    waitAll();
}

std::vector<uint8_t> AppDevice::download(const AppImage& image, uint32_t layer) {
    waitAll();
    std::vector<uint8_t> bytes(size_t(image.width) * image.height * bytesPerPixel(image.format));
    staging(bytes.size());
    const VkCommandBuffer commands = begin(kUploadSlot);
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, layer, 1};
    region.imageExtent = {image.width, image.height, 1};
    vkCmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, staging_.buffer, 1, &region);
    VkMemoryBarrier host{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    host.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    host.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &host, 0, nullptr, 0, nullptr);
    submit(kUploadSlot);
    waitAll();
    std::memcpy(bytes.data(), staging_.mapped, bytes.size());
    return bytes;
}

VkCommandBuffer AppDevice::begin(uint32_t slot) {
    MUST(vkWaitForFences(device, 1, &fences_[slot], VK_TRUE, UINT64_MAX));
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    MUST(vkBeginCommandBuffer(commands_[slot], &info));
    return commands_[slot];
}

void AppDevice::submit(uint32_t slot, VkSemaphore wait, VkSemaphore signal) {
    MUST(vkEndCommandBuffer(commands_[slot]));
    MUST(vkResetFences(device, 1, &fences_[slot]));
    VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands_[slot];
    const VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    info.waitSemaphoreCount = wait ? 1 : 0, info.pWaitSemaphores = &wait, info.pWaitDstStageMask = &all;
    info.signalSemaphoreCount = signal ? 1 : 0, info.pSignalSemaphores = &signal;
    MUST(vkQueueSubmit(queue, 1, &info, fences_[slot]));
}

void AppDevice::waitAll() {
    MUST(vkWaitForFences(device, kSlots, fences_, VK_TRUE, UINT64_MAX));
}

}  // namespace dpl::test
