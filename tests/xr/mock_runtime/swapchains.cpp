// SPDX-License-Identifier: Apache-2.0
// Swapchains: images on the caller's device, handed out in turn.
#include <algorithm>

#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"

namespace dpl::mockxr {
namespace {

VkImageUsageFlags vulkanUsage(XrSwapchainUsageFlags flags) {
    VkImageUsageFlags usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;  // to read them
    if (flags & XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT) usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    if (flags & XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT) usage |= VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    if (flags & XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT) usage |= VK_IMAGE_USAGE_STORAGE_BIT;
    if (flags & XR_SWAPCHAIN_USAGE_SAMPLED_BIT) usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
    return usage;
}

}  // namespace

namespace entry {

DPL_MOCKXR_ENTRY(xrEnumerateSwapchainFormats)(XrSession, uint32_t capacity, uint32_t* count, int64_t* out) {
    return enumerate(capacity, count, out, runtime().settings.formats);
}

DPL_MOCKXR_ENTRY(xrCreateSwapchain)(XrSession session, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_SWAPCHAIN_CREATE_INFO, "createInfo"));
    const auto& formats = r.settings.formats;
    if (std::find(formats.begin(), formats.end(), info->format) == formats.end())
        return violated(XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, "format " + std::to_string(info->format) + " was not enumerated");
    if (info->createFlags != 0) return violated(XR_ERROR_FEATURE_UNSUPPORTED, "create flags are not supported");
    if (info->width == 0 || info->height == 0 || info->width > r.settings.maxSidePx || info->height > r.settings.maxSidePx)
        return violated(XR_ERROR_VALIDATION_FAILURE, "the image is empty or larger than the system allows");
    if (info->arraySize == 0 || info->mipCount == 0 || info->faceCount != 1 || info->sampleCount != 1)
        return violated(XR_ERROR_VALIDATION_FAILURE, "arraySize, mipCount, faceCount or sampleCount is wrong");
    const bool depth = VulkanCalls::isDepth(VkFormat(info->format));
    const XrSwapchainUsageFlags attachment =
        depth ? XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
    if (!(info->usageFlags & attachment))
        return violated(XR_ERROR_VALIDATION_FAILURE, "the usage lacks the kind of attachment that the format is for");
    VkImageCreateInfo image{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    if (info->usageFlags & XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT) image.flags = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
    image.imageType = VK_IMAGE_TYPE_2D;
    image.format = VkFormat(info->format);
    image.extent = {info->width, info->height, 1};
    image.mipLevels = info->mipCount, image.arrayLayers = info->arraySize;
    image.samples = VK_SAMPLE_COUNT_1_BIT;
    image.usage = vulkanUsage(info->usageFlags);
    *swapchain = r.newHandle<XrSwapchain>();
    Swapchain& made = r.swapchains[*swapchain];
    made.session = session, made.info = *info, made.number = ++r.swapchainsMade;
    made.info.next = nullptr;
    for (uint32_t i = 0; i < r.settings.swapchainImages; ++i)
        if (!r.sessions.at(session).vulkan.makeImage(image, made.images.emplace_back(), made.memories.emplace_back())) {
            destroySwapchain(*swapchain);
            return XR_ERROR_RUNTIME_FAILURE;
        }
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrDestroySwapchain)(XrSwapchain swapchain) {
    destroySwapchain(swapchain);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrEnumerateSwapchainImages)(XrSwapchain handle, uint32_t capacity, uint32_t* count, XrSwapchainImageBaseHeader* out) {
    const Swapchain& swapchain = runtime().swapchains.at(handle);
    return enumerate(capacity, count, reinterpret_cast<XrSwapchainImageVulkan2KHR*>(out), swapchain.images.size(),
                     [&](size_t i, XrSwapchainImageVulkan2KHR& element) {
                         DPL_MOCKXR_TRY(checkStructure(&element, XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR, "an element of images"));
                         element.image = swapchain.images[i];
                         return XR_SUCCESS;
                     });
}

DPL_MOCKXR_ENTRY(xrAcquireSwapchainImage)(XrSwapchain handle, const XrSwapchainImageAcquireInfo* info, uint32_t* index) {
    Swapchain& swapchain = runtime().swapchains.at(handle);
    if (info) DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO, "acquireInfo"));
    if (swapchain.acquired.size() == swapchain.images.size())
        return violated(XR_ERROR_CALL_ORDER_INVALID, "all images of the swapchain are acquired already");
    *index = swapchain.next;
    swapchain.acquired.push_back(swapchain.next);
    swapchain.next = (swapchain.next + 1) % uint32_t(swapchain.images.size());
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrWaitSwapchainImage)(XrSwapchain handle, const XrSwapchainImageWaitInfo* info) {
    Swapchain& swapchain = runtime().swapchains.at(handle);
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, "waitInfo"));
    if (swapchain.acquired.empty() || swapchain.waited)
        return violated(XR_ERROR_CALL_ORDER_INVALID, "no image is acquired, or the oldest one was waited for already");
    if (info->timeout < 0) return violated(XR_ERROR_VALIDATION_FAILURE, "the time-out is negative");
    swapchain.waited = true;
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrReleaseSwapchainImage)(XrSwapchain handle, const XrSwapchainImageReleaseInfo* info) {
    Swapchain& swapchain = runtime().swapchains.at(handle);
    if (info) DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO, "releaseInfo"));
    if (!swapchain.waited) return violated(XR_ERROR_CALL_ORDER_INVALID, "no image was waited for");
    swapchain.released = swapchain.acquired.front();
    swapchain.releasedInFrame = runtime().counts.begun;
    swapchain.acquired.pop_front();
    swapchain.waited = false;
    return XR_SUCCESS;
}

}  // namespace entry
}  // namespace dpl::mockxr
