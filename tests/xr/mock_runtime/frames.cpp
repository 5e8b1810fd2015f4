// SPDX-License-Identifier: Apache-2.0
// Frames: wait, begin, end, and the checks of the layers that end a frame.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/xr/mock_runtime/check.h"
#include "tests/xr/mock_runtime/entry_points.h"

namespace dpl::mockxr {
namespace {

XrResult checkFov(const XrFovf& fov) {
    const float limit = 1.5707963f;
    for (const float angle : {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown})
        if (!(std::abs(angle) < limit))
            return violated(XR_ERROR_VALIDATION_FAILURE, "an angle of the field of view is not below 90 degrees");
    if (fov.angleLeft >= fov.angleRight || fov.angleDown >= fov.angleUp)
        return violated(XR_ERROR_VALIDATION_FAILURE, "the field of view is empty");
    return XR_SUCCESS;
}

XrResult checkSubImage(XrSession session, const XrSwapchainSubImage& sub, bool depth) {
    const std::string kind = depth ? "the depth image" : "the colour image";
    const auto found = runtime().swapchains.find(sub.swapchain);
    if (found == runtime().swapchains.end() || found->second.session != session)
        return violated(XR_ERROR_HANDLE_INVALID, "the swapchain of " + kind + " is not alive in this session");
    const Swapchain& swapchain = found->second;
    if (!swapchain.released) return violated(XR_ERROR_LAYER_INVALID, kind + " was never released");
    const XrSwapchainUsageFlags usage = depth ? XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
    if (!(swapchain.info.usageFlags & usage) || VulkanCalls::isDepth(VkFormat(swapchain.info.format)) != depth)
        return violated(XR_ERROR_LAYER_INVALID, kind + " has the usage or the format of another kind");
    if (sub.imageArrayIndex >= swapchain.info.arraySize)
        return violated(XR_ERROR_VALIDATION_FAILURE, "array index " + std::to_string(sub.imageArrayIndex) + " of " + kind + " is outside");
    const XrRect2Di& rect = sub.imageRect;
    if (rect.offset.x < 0 || rect.offset.y < 0 || rect.extent.width <= 0 || rect.extent.height <= 0 ||
        int64_t(rect.offset.x) + rect.extent.width > int64_t(swapchain.info.width) ||
        int64_t(rect.offset.y) + rect.extent.height > int64_t(swapchain.info.height))
        return violated(XR_ERROR_SWAPCHAIN_RECT_INVALID, "the rectangle of " + kind + " is empty or outside");
    return XR_SUCCESS;
}

XrResult checkDepth(XrSession session, const XrCompositionLayerDepthInfoKHR& depth) {
    DPL_MOCKXR_TRY(checkEnabled(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME));
    DPL_MOCKXR_TRY(checkSubImage(session, depth.subImage, true));
    if (!(depth.minDepth >= 0 && depth.minDepth < depth.maxDepth && depth.maxDepth <= 1))
        return violated(XR_ERROR_VALIDATION_FAILURE, "minDepth and maxDepth are not in order from 0 to 1");
    if (!(depth.nearZ > 0) || !(depth.farZ > 0) || depth.nearZ == depth.farZ)
        return violated(XR_ERROR_VALIDATION_FAILURE, "nearZ and farZ are not positive and different");
    return XR_SUCCESS;
}

SubmittedView describe(const XrCompositionLayerProjectionView& view, const XrCompositionLayerDepthInfoKHR* depth) {
    Runtime& r = runtime();
    const Swapchain& swapchain = r.swapchains.at(view.subImage.swapchain);
    SubmittedView out{};
    out.pose = view.pose, out.fov = view.fov, out.rect = view.subImage.imageRect;
    out.swapchain = swapchain.number, out.layer = view.subImage.imageArrayIndex, out.format = swapchain.info.format;
    out.fresh = swapchain.releasedInFrame == r.counts.begun;
    if (depth) {
        out.hasDepth = true;
        out.minDepth = depth->minDepth, out.maxDepth = depth->maxDepth, out.nearZ = depth->nearZ, out.farZ = depth->farZ;
    }
    return out;
}

XrResult checkProjection(XrSession handle, const XrCompositionLayerProjection& layer, SubmittedLayer& out) {
    Runtime& r = runtime();
    DPL_MOCKXR_TRY(checkStructure(&layer, XR_TYPE_COMPOSITION_LAYER_PROJECTION, "a projection layer"));
    const auto space = r.spaces.find(layer.space);
    if (space == r.spaces.end() || space->second.session != handle)
        return violated(XR_ERROR_HANDLE_INVALID, "the space of the projection layer is not alive in this session");
    if (layer.viewCount != r.settings.views.size() || !layer.views)
        return violated(XR_ERROR_VALIDATION_FAILURE, "the projection layer has " + std::to_string(layer.viewCount) + " views instead of " +
                                                         std::to_string(r.settings.views.size()));
    for (uint32_t i = 0; i < layer.viewCount; ++i) {
        const XrCompositionLayerProjectionView& view = layer.views[i];
        DPL_MOCKXR_TRY(checkStructure(&view, XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, "a projection view",
                                      {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR}));
        DPL_MOCKXR_TRY(checkPose(view.pose, "a projection view"));
        DPL_MOCKXR_TRY(checkFov(view.fov));
        DPL_MOCKXR_TRY(checkSubImage(handle, view.subImage, false));
        const auto* depth = chained<XrCompositionLayerDepthInfoKHR>(view.next, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR);
        if (depth) DPL_MOCKXR_TRY(checkDepth(handle, *depth));
        out.views.push_back(describe(view, depth));
    }
    return XR_SUCCESS;
}

float storedDepth(const uint8_t* bytes, VkFormat format) {
    if (format == VK_FORMAT_D16_UNORM) {
        uint16_t code;
        std::memcpy(&code, bytes, 2);
        return float(code) / 65535;
    }
    if (format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D32_SFLOAT_S8_UINT) {
        float value;
        std::memcpy(&value, bytes, 4);
        return value;
    }
    uint32_t code;
    std::memcpy(&code, bytes, 4);
    return float(code & 0xFFFFFF) / 0xFFFFFF;
}

/** Reads the pictures of a layer, and the depth beside them. */
XrResult capture(Session& session, const XrCompositionLayerProjection& layer, SubmittedLayer& out) {
    Runtime& r = runtime();
    std::vector<VulkanCalls::Copy> copies;
    const auto add = [&](const XrSwapchainSubImage& sub) {
        const Swapchain& swapchain = r.swapchains.at(sub.swapchain);
        const XrRect2Di& rect = sub.imageRect;
        copies.push_back({swapchain.images[*swapchain.released],
                          VkFormat(swapchain.info.format),
                          sub.imageArrayIndex,
                          {{rect.offset.x, rect.offset.y}, {uint32_t(rect.extent.width), uint32_t(rect.extent.height)}},
                          {}});
    };
    for (uint32_t i = 0; i < layer.viewCount; ++i) {
        add(layer.views[i].subImage);
        if (const auto* depth = chained<XrCompositionLayerDepthInfoKHR>(layer.views[i].next, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR))
            add(depth->subImage);
    }
    if (!session.vulkan.read(copies)) return XR_ERROR_RUNTIME_FAILURE;
    size_t next = 0;
    for (SubmittedView& view : out.views) {
        view.pixels = std::move(copies[next++].bytes);
        if (!view.hasDepth) continue;
        const VulkanCalls::Copy& depth = copies[next++];
        const uint32_t bytes = VulkanCalls::bytesPerPixel(depth.format);
        for (size_t i = 0; i < depth.bytes.size(); i += bytes) view.depth.push_back(storedDepth(&depth.bytes[i], depth.format));
    }
    return XR_SUCCESS;
}

XrResult checkLayer(XrSession handle, const XrCompositionLayerBaseHeader* layer, SubmittedLayer& out) {
    Runtime& r = runtime();
    if (!layer) return violated(XR_ERROR_LAYER_INVALID, "a layer is null");
    out.type = layer->type, out.flags = layer->layerFlags;
    const XrCompositionLayerFlags known = XR_COMPOSITION_LAYER_CORRECT_CHROMATIC_ABERRATION_BIT |
                                          XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT |
                                          XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;
    if (layer->layerFlags & ~known) return violated(XR_ERROR_VALIDATION_FAILURE, "a layer has unknown flags");
    if (layer->type == XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB) {
        DPL_MOCKXR_TRY(checkEnabled(XR_FB_PASSTHROUGH_EXTENSION_NAME));
        DPL_MOCKXR_TRY(checkStructure(layer, XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB, "a passthrough layer"));
        if (!r.passthroughLayers.count(reinterpret_cast<const XrCompositionLayerPassthroughFB*>(layer)->layerHandle))
            return violated(XR_ERROR_HANDLE_INVALID, "the passthrough layer is not alive");
        return XR_SUCCESS;
    }
    if (layer->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION)
        return violated(XR_ERROR_LAYER_INVALID, "a layer has type " + std::to_string(layer->type));
    return checkProjection(handle, *reinterpret_cast<const XrCompositionLayerProjection*>(layer), out);
}

}  // namespace

namespace entry {

DPL_MOCKXR_ENTRY(xrWaitFrame)(XrSession handle, const XrFrameWaitInfo* info, XrFrameState* state) {
    Runtime& r = runtime();
    Session& session = r.sessions.at(handle);
    if (info) DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_FRAME_WAIT_INFO, "frameWaitInfo"));
    DPL_MOCKXR_TRY(checkStructure(state, XR_TYPE_FRAME_STATE, "frameState"));
    if (!session.running) return violated(XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    if (session.waited) return violated(XR_ERROR_CALL_ORDER_INVALID, "the frame before was not begun: a runtime may block here for ever");
    session.waited = true;
    ++r.counts.waited;
    const XrTime time = r.displayTime += r.periodNs();
    if (r.nextWorldFromLocal && time >= r.localChangesAt) {
        r.worldFromLocal = *r.nextWorldFromLocal;
        r.nextWorldFromLocal.reset();
    }
    session.predicted.insert(time);
    state->predictedDisplayTime = time;
    state->predictedDisplayPeriod = r.periodNs();
    const bool seen = session.told == XR_SESSION_STATE_VISIBLE || session.told == XR_SESSION_STATE_FOCUSED;
    state->shouldRender = r.settings.shouldRender.value_or(seen);
    return XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrBeginFrame)(XrSession handle, const XrFrameBeginInfo* info) {
    Runtime& r = runtime();
    Session& session = r.sessions.at(handle);
    if (info) DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_FRAME_BEGIN_INFO, "frameBeginInfo"));
    if (!session.running) return violated(XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    if (!session.waited) return violated(XR_ERROR_CALL_ORDER_INVALID, "xrWaitFrame was not called before");
    const bool discarded = session.begun;
    session.waited = false, session.begun = true;
    ++r.counts.begun;
    if (discarded) ++r.counts.discarded;
    return discarded ? XR_FRAME_DISCARDED : XR_SUCCESS;
}

DPL_MOCKXR_ENTRY(xrEndFrame)(XrSession handle, const XrFrameEndInfo* info) {
    Runtime& r = runtime();
    Session& session = r.sessions.at(handle);
    DPL_MOCKXR_TRY(checkStructure(info, XR_TYPE_FRAME_END_INFO, "frameEndInfo"));
    if (!session.running) return violated(XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    if (!session.begun) return violated(XR_ERROR_CALL_ORDER_INVALID, "xrBeginFrame was not called before");
    DPL_MOCKXR_TRY(checkTime(info->displayTime));
    if (!session.predicted.count(info->displayTime))
        return violated(XR_ERROR_TIME_INVALID, "displayTime is not one that xrWaitFrame predicted for a frame that is not ended yet");
    const auto& modes = r.settings.blendModes;
    if (std::find(modes.begin(), modes.end(), info->environmentBlendMode) == modes.end())
        return violated(XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, "the system does not have the blend mode");
    if (info->layerCount > XR_MIN_COMPOSITION_LAYERS_SUPPORTED) return violated(XR_ERROR_LAYER_LIMIT_EXCEEDED, "too many layers");
    if (info->layerCount > 0 && !info->layers) return violated(XR_ERROR_VALIDATION_FAILURE, "layers is null");
    SubmittedFrame frame;
    frame.displayTime = info->displayTime;
    frame.blendMode = info->environmentBlendMode;
    for (uint32_t i = 0; i < info->layerCount; ++i) DPL_MOCKXR_TRY(checkLayer(handle, info->layers[i], frame.layers.emplace_back()));
    for (uint32_t i = 0; i < info->layerCount && r.settings.capture; ++i)
        if (info->layers[i]->type == XR_TYPE_COMPOSITION_LAYER_PROJECTION)
            DPL_MOCKXR_TRY(capture(session, *reinterpret_cast<const XrCompositionLayerProjection*>(info->layers[i]), frame.layers[i]));
    r.submitted = std::move(frame);
    session.begun = false;
    session.predicted.clear();
    ++r.counts.ended;
    if (!session.firstFrameEnded && r.settings.automaticStates)
        for (const XrSessionState state : {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED})
            r.sendState(handle, state);
    session.firstFrameEnded = true;
    return XR_SUCCESS;
}

}  // namespace entry
}  // namespace dpl::mockxr
