// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/images.h"

#include <algorithm>

#include "platform/openxr/enumerate.h"

namespace dpl::xr {
namespace {

// Best first. Compositors take UNORM pixels for linear light, while Doppel blends display-referred values into UNORM images: so there is
// no UNORM format here.
constexpr VkFormat kColourFormats[] = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT};
constexpr VkFormat kDepthFormats[] = {VK_FORMAT_D32_SFLOAT, VK_FORMAT_D32_SFLOAT_S8_UINT, VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_D16_UNORM};

}  // namespace

Images::~Images() {
    for (Group& group : groups_) {
        for (VkImageView view : group.views) vkDestroyImageView(runtime_.device(), view, nullptr);
        vkDestroyImage(runtime_.device(), group.ownDepth, nullptr);
        vkFreeMemory(runtime_.device(), group.memory, nullptr);
    }
}

Status Images::make(Calls& calls_, XrSession session, const Display& display, const SessionOptions& options) {
    std::vector<int64_t> formats;
    DPL_XR_OK(calls_.check(
        enumerate(formats, int64_t(0),
                  [&](auto capacity, auto count, auto out) { return xrEnumerateSwapchainFormats(session, capacity, count, out); }),
        "xrEnumerateSwapchainFormats"));
    groups_.resize(display.groupCount);
    shown_.groups.resize(display.groupCount);
    for (uint32_t i = 0; i < display.groupCount; ++i) {
        GroupImages& group = shown_.groups[i];
        group.widthPx = uint32_t(display.sizes[i].width), group.heightPx = uint32_t(display.sizes[i].height);
        group.views = display.viewsOf(i);
    }
    DPL_XR_OK(makeColour(calls_, session, display, options, formats));
    DPL_XR_OK(makeDepth(calls_, session, display, options, formats));
    for (uint32_t i = 0; i < groups_.size(); ++i) DPL_XR_OK(makeViews(i));
    return {};
}

Result<Images::Chains> Images::makeChains(Calls& calls, XrSession session, const Display& display, bool array, VkFormat format,
                                          XrSwapchainUsageFlags usage) const {
    Chains chains(display.groupCount);
    for (uint32_t i = 0; i < display.groupCount; ++i) {
        XrSwapchainCreateInfo info{XR_TYPE_SWAPCHAIN_CREATE_INFO};
        info.usageFlags = usage;
        info.format = format;
        info.sampleCount = info.faceCount = info.mipCount = 1;
        info.width = shown_.groups[i].widthPx, info.height = shown_.groups[i].heightPx;
        info.arraySize = array ? shown_.groups[i].views : 1;
        for (uint32_t n = 0; n < (array ? 1 : shown_.groups[i].views); ++n) {
            auto made = Swapchain::create(runtime_, calls, session, info);
            if (!made) return made.error();
            chains[i].push_back(std::move(*made));
        }
    }
    return chains;
}

Status Images::makeColour(Calls& calls, XrSession session, const Display& display, const SessionOptions& options,
                          const std::vector<int64_t>& formats) {
    const XrSwapchainUsageFlags usage =
        XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | (options.capture ? XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT : 0);
    Status last =
        Error{DPL_ERROR_UNSUPPORTED,
              "the runtime offers images neither in R8G8B8A8_SRGB or B8G8R8A8_SRGB nor in R16G16B16A16_SFLOAT; others do not hold light "
              "as compositors read it; update it or use another runtime"};
    for (const bool array : {true, false}) {
        if (array && !options.array) continue;
        for (const VkFormat format : kColourFormats) {
            if (std::find(formats.begin(), formats.end(), int64_t(format)) == formats.end()) continue;
            auto made = makeChains(calls, session, display, array, format, usage);
            if (made) {
                for (size_t i = 0; i < groups_.size(); ++i) groups_[i].colour = std::move((*made)[i]);
                array_ = array;
                shown_.colourFormat = format;
                shown_.multiview = array && runtime_.multiview() && display.viewCount > 1;
                for (GroupImages& group : shown_.groups) group.passes = shown_.multiview ? 1 : group.views;
                return {};
            }
            last = made.error();
            if (calls.sessionLost) return last;
        }
    }
    return last;
}

bool Images::canDrawDepth(VkFormat format) const {
    constexpr VkFormatFeatureFlags kNeeded = VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
    VkFormatProperties properties{};
    vkGetPhysicalDeviceFormatProperties(runtime_.physicalDevice(), format, &properties);
    return (properties.optimalTilingFeatures & kNeeded) == kNeeded;
}

Status Images::makeDepth(Calls& calls, XrSession session, const Display& display, const SessionOptions& options,
                         const std::vector<int64_t>& formats) {
    const XrSwapchainUsageFlags usage = XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT |
                                        (options.capture ? XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT : 0);
    for (const VkFormat format : kDepthFormats) {
        if (!runtime_.extensions().depthLayer || !canDrawDepth(format) ||
            std::find(formats.begin(), formats.end(), int64_t(format)) == formats.end())
            continue;
        auto made = makeChains(calls, session, display, array_, format, usage);
        if (made) {
            for (size_t i = 0; i < groups_.size(); ++i) groups_[i].depth = std::move((*made)[i]);
            shown_.depthFormat = format;
            return {};
        }
        if (calls.sessionLost) return made.error();
    }
    // The runtime takes no depth: the scene's own depth still hides what is behind it.
    const auto format = std::find_if(std::begin(kDepthFormats), std::end(kDepthFormats), [&](VkFormat f) { return canDrawDepth(f); });
    if (format == std::end(kDepthFormats)) return Error{DPL_ERROR_UNSUPPORTED, "the GPU has no depth format that can be drawn and read"};
    shown_.depthFormat = *format;
    for (uint32_t i = 0; i < groups_.size(); ++i) DPL_XR_OK(makeOwnDepth(i));
    return {};
}

Status Images::makeOwnDepth(uint32_t index) {
    Group& group = groups_[index];
    const GroupImages& shown = shown_.groups[index];
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = shown_.depthFormat;
    info.extent = {shown.widthPx, shown.heightPx, 1};
    info.mipLevels = 1;
    info.arrayLayers = shown.views;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    DPL_XR_OK(Calls::check(vkCreateImage(runtime_.device(), &info, nullptr, &group.ownDepth), "vkCreateImage"));
    VkMemoryRequirements needs{};
    vkGetImageMemoryRequirements(runtime_.device(), group.ownDepth, &needs);
    const auto type = runtime_.memoryType(needs.memoryTypeBits, 0);
    if (!type) return type.error();
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = *type;
    DPL_XR_OK(Calls::check(vkAllocateMemory(runtime_.device(), &allocation, nullptr, &group.memory), "vkAllocateMemory"));
    return Calls::check(vkBindImageMemory(runtime_.device(), group.ownDepth, group.memory, 0), "vkBindImageMemory");
}

Result<VkImageView> Images::makeView(Group& group, VkImage image, VkFormat format, VkImageAspectFlags aspect, uint32_t layer,
                                     uint32_t layers) {
    VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
    info.format = format;
    info.subresourceRange = {aspect, 0, 1, layer, layers};
    VkImageView view = VK_NULL_HANDLE;
    DPL_XR_OK(Calls::check(vkCreateImageView(runtime_.device(), &info, nullptr, &view), "vkCreateImageView"));
    group.views.push_back(view);
    return view;
}

Status Images::makeViews(uint32_t index) {
    Group& group = groups_[index];
    GroupImages& shown = shown_.groups[index];
    const uint32_t layers = shown_.multiview ? shown.views : 1;
    for (uint32_t pass = 0; pass < shown.passes; ++pass) {
        const uint32_t layer = array_ ? pass : 0, chain = array_ ? 0 : pass;
        for (VkImage image : group.colour[chain].images()) {
            auto view = makeView(group, image, shown_.colourFormat, VK_IMAGE_ASPECT_COLOR_BIT, layer, layers);
            if (!view) return view.error();
            shown.colour[pass].push_back(*view);
        }
        const std::vector<VkImage> own = {group.ownDepth};
        for (VkImage image : group.ownDepth ? own : group.depth[chain].images()) {
            // Attachments are whole images; Doppel samples the depth aspect alone.
            const uint32_t first = group.ownDepth ? pass : layer;
            auto view = makeView(group, image, shown_.depthFormat, depthAspects(), first, layers);
            if (!view) return view.error();
            shown.depth[pass].push_back(*view);
            auto sampled = makeView(group, image, shown_.depthFormat, VK_IMAGE_ASPECT_DEPTH_BIT, first, layers);
            if (!sampled) return sampled.error();
            group.sampledDepth[pass].push_back(*sampled);
        }
    }
    return {};
}

Result<bool> Images::acquire(Calls& calls) {
    bool all = true;
    for (Group& group : groups_)
        for (auto* chains : {&group.colour, &group.depth})
            for (Swapchain& chain : *chains) {
                const auto ready = chain.acquire(calls);
                if (!ready) return ready.error();
                all &= *ready;
            }
    return all;
}

Status Images::release(Calls& calls) {
    Status first;
    for (Group& group : groups_)
        for (auto* chains : {&group.colour, &group.depth})
            for (Swapchain& chain : *chains)
                if (Status released = chain.release(calls); !released && first) first = released;
    return first;
}

void Images::describe(uint32_t index, float nearM, GroupFrame& frame) const {
    const Group& group = groups_[index];
    const GroupImages& shown = shown_.groups[index];
    for (uint32_t pass = 0; pass < shown.passes; ++pass) {
        const uint32_t chain = array_ ? 0 : pass;
        frame.colourImage[pass] = group.colour[chain].current();
        frame.depthImage[pass] = group.ownDepth ? 0 : group.depth[chain].current();
    }
    for (uint32_t v = 0; v < shown.views; ++v) {
        const uint32_t pass = shown_.multiview ? 0 : v;
        DplVulkanSceneDepth& depth = frame.depths[v];
        depth = {};
        depth.structSize = sizeof depth;
        depth.image = group.sampledDepth[pass][frame.depthImage[pass]];
        depth.layer = shown_.multiview ? v : 0;
        depth.layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;
        depth.samples = 1;
        depth.scale = 0, depth.offset = nearM;  // reversed, infinite far plane
    }
}

VkImageAspectFlags Images::depthAspects() const {
    const bool stencil = shown_.depthFormat == VK_FORMAT_D32_SFLOAT_S8_UINT || shown_.depthFormat == VK_FORMAT_D24_UNORM_S8_UINT;
    return VK_IMAGE_ASPECT_DEPTH_BIT | (stencil ? VK_IMAGE_ASPECT_STENCIL_BIT : 0);
}

void Images::giveDepthBack(VkCommandBuffer commands) const {
    VkImageMemoryBarrier barriers[kMaxViews]{};
    uint32_t count = 0;
    for (size_t i = 0; i < groups_.size(); ++i)
        for (const Swapchain& chain : groups_[i].depth) {
            VkImageMemoryBarrier& barrier = barriers[count++];
            barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
            barrier.dstAccessMask = VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
            barrier.oldLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;
            barrier.newLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
            barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
            barrier.image = chain.images()[chain.current()];
            barrier.subresourceRange = {depthAspects(), 0, 1, 0, array_ ? shown_.groups[i].views : 1};
        }
    if (count == 0) return;
    constexpr VkPipelineStageFlags kTests = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | kTests, kTests, 0, 0, nullptr, 0,
                         nullptr, count, barriers);
}

Images::Place Images::colourOf(uint32_t group, uint32_t view) const {
    const Swapchain& chain = groups_[group].colour[array_ ? 0 : view];
    return {chain.images()[chain.current()], array_ ? view : 0};
}

Images::Place Images::depthOf(uint32_t group, uint32_t view) const {
    if (groups_[group].ownDepth) return {groups_[group].ownDepth, view};
    const Swapchain& chain = groups_[group].depth[array_ ? 0 : view];
    return {chain.images()[chain.current()], array_ ? view : 0};
}

XrSwapchainSubImage Images::layerOf(const std::vector<Swapchain>& chains, uint32_t group, uint32_t view) const {
    const GroupImages& shown = shown_.groups[group];
    return {chains[array_ ? 0 : view].handle(), {{0, 0}, {int32_t(shown.widthPx), int32_t(shown.heightPx)}}, array_ ? view : 0};
}

}  // namespace dpl::xr
