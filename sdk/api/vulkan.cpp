// SPDX-License-Identifier: Apache-2.0
// Contexts on a program's own Vulkan device, and the frames that become part of the program's frames.
#include "sdk/include/doppel/doppel_vulkan.h"

#include <iterator>

#include "sdk/api/app_frame.h"
#include "sdk/api/create_renderer.h"
#include "sdk/api/write_on_gpu.h"
#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::api {

/** What only a context on the program's device has. The context owns the renderer, which owns the backend. */
struct VulkanSide {
    GpuRenderer& renderer;
    vk::VulkanBackend& backend;
};

namespace {

static_assert(DPL_VULKAN_SLOTS == kAppSlots && DPL_VULKAN_DEPTH_COVERAGE == gpu::kDepthCoverage);

constexpr DplVulkanRequirement kRequirements[] = {
    {0, "VkPhysicalDeviceProperties::apiVersion >= VK_API_VERSION_1_1", DPL_TRUE, "the least that Doppel draws with"},
    {0, "VkQueueFamilyProperties::queueFlags with VK_QUEUE_GRAPHICS_BIT and VK_QUEUE_COMPUTE_BIT", DPL_TRUE,
     "one queue draws and computes"},
    {0, "VkPhysicalDeviceMultiviewFeatures::multiview", DPL_FALSE,
     "one draw fills both eyes; composers for passes with a view mask need it"},
    {0, "VkPhysicalDeviceFeatures::sampleRateShading", DPL_FALSE,
     "four samples a pixel where a pixel is coarser than those an avatar was trained on; without it far avatars lose detail"},
    {0, "VkPhysicalDeviceFeatures::shaderStorageImageExtendedFormats", DPL_FALSE,
     "faster reads on drivers that run on the CPU; GPUs do not use it"},
};

vk::AppDevice appDeviceOf(const DplVulkanDevice& given) {
    vk::AppDevice app;
    app.getInstanceProcAddr = given.getInstanceProcAddr;
    app.instance = given.instance, app.physical = given.physicalDevice, app.device = given.device;
    app.queue = given.queue, app.queueFamily = given.queueFamily;
    app.enabled = given.enabledFeatures, app.allocator = given.allocator;
    app.lockQueue = given.lockQueue, app.unlockQueue = given.unlockQueue, app.user = given.user;
    return app;
}

/** The Vulkan side of a context whose mutex is locked. */
Result<VulkanSide*> sideOf(const Context& context) {
    DPL_RETURN_IF_ERROR(checkUsable(context));
    if (!context.vulkan)
        return fail(Code::InvalidArgument, "the context is not on the program's Vulkan device; make it with dplCreateVulkanContext");
    return context.vulkan.get();
}

struct NewRenderer {
    std::unique_ptr<Renderer> renderer;
    std::shared_ptr<VulkanSide> side;  // null: not on the program's device
};
/** On the program's device. */
Result<NewRenderer> lentRenderer(const DplVulkanDevice& given, const RendererOptions& options) {
    DPL_TRY(auto backend, vk::createBackendOn(appDeviceOf(given)));
    vk::VulkanBackend& lent = *backend;
    std::string name = "vulkan: " + lent.info().name;
    auto renderer = std::make_unique<GpuRenderer>(std::move(backend), std::move(name));
    DPL_RETURN_IF_ERROR(setFill(*renderer, options));
    auto side = std::make_shared<VulkanSide>(VulkanSide{*renderer, lent});
    return NewRenderer{std::move(renderer), std::move(side)};
}

/** A renderer on a new device, with the avatars of the context. The context's mutexes are locked. */
Result<NewRenderer> rebuilt(const Context& context, const DplVulkanDevice* device) {
    if (!context.renderer) return fail(Code::InvalidArgument, "the context was destroyed");
    if (context.renderer->identity().empty())
        return fail(Code::InvalidArgument, "the context draws on the CPU ({}): there is no device to lose", context.rendererName);
    if (drawsByMetal(*context.renderer))
        return fail(Code::InvalidArgument, "the context draws by Metal ({}); dplRebuildMetal replaces its device", context.rendererName);
    if (context.vulkan && !device)
        return fail(Code::InvalidArgument,
                    "device is NULL, but the context was made on a device of the program; open a new one and give it");
    if (!context.vulkan && device)
        return fail(Code::InvalidArgument, "the context was not made with dplCreateVulkanContext; device must be NULL");
    NewRenderer made;
    if (device) {
        DPL_TRY(const DplVulkanDevice given, readStruct<DplVulkanDevice>(device, "device"));
        DPL_TRY(made, lentRenderer(given, context.request.options));
        made.side->backend.numberAfter(context.vulkan->backend.lastNumber());
    } else {
        DPL_TRY(made.renderer, createGpuRenderer(context.request.kind, context.request.options));
    }
    DPL_RETURN_IF_ERROR(made.renderer->addAll(*context.renderer));
    return made;
}

vk::AppPass passOf(const DplVulkanPass& given) {
    vk::AppPass pass;
    pass.renderPass = given.renderPass, pass.subpass = given.subpass, pass.viewMask = given.viewMask;
    pass.samples = given.samples == 0 ? 1 : given.samples;
    pass.colour = given.colourFormat, pass.depth = given.depthFormat, pass.stencil = given.stencilFormat;
    pass.written = PictureDepth(given.writesDepth);
    return pass;
}

/** Whether a shader may read a depth image in this layout. Layouts of extensions that are not known here may. */
bool isReadable(VkImageLayout layout) {
    switch (layout) {
        case VK_IMAGE_LAYOUT_UNDEFINED:
        case VK_IMAGE_LAYOUT_PREINITIALIZED:
        case VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL:
        case VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL:
        case VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL:
        case VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_STENCIL_READ_ONLY_OPTIMAL:
        case VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL:
        case VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL:
            return false;
        default:
            return true;
    }
}

/** Reads the depths of a call. images: viewCount of them. */
Status takeDepths(const DplVulkanSceneDepth* depths, uint32_t viewCount, vk::SceneImage* images) {
    for (uint32_t v = 0; v < viewCount; ++v) {
        DPL_TRY(const DplVulkanSceneDepth given, element(depths, v, "depths"));
        const uint32_t samples = given.samples == 0 ? 1 : given.samples;
        if (!given.image) return fail(Code::InvalidArgument, "depth {} has no image", v);
        if (!isReadable(given.layout))
            return fail(
                Code::InvalidArgument,
                "depth {} is in VkImageLayout {}, in which no shader can read it; end the pass that writes it and change its layout, "
                "for example to VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL",
                v, int(given.layout));
        if (samples != 1 && samples != 4) return fail(Code::InvalidArgument, "depth {} has {} samples; 1 and 4 are possible", v, samples);
        DPL_RETURN_IF_ERROR(checkProjection(given.scale, given.offset));
        images[v] = {given.image, given.layout, samples, {given.layer, given.x, given.y, {given.scale, given.offset}}};
    }
    return {};
}

Status prepare(const PictureCall& call, const DplVulkanSceneDepth* depths, FunctionRef<Result<AppCommands>(vk::VulkanBackend&)> begin,
               FunctionRef<Status(vk::VulkanBackend&)> end) {
    DPL_TRY(Scene scene, sceneOf(call.context, call.avatars, call.viewCount));
    DPL_TRY(VulkanSide * side, sideOf(*scene.context));
    vk::VulkanBackend& backend = side->backend;
    DPL_RETURN_IF_ERROR(takeViews(scene, call.views, call.viewCount));
    vk::SceneImage images[DPL_MAX_VIEWS];
    if (depths) {
        DPL_RETURN_IF_ERROR(takeDepths(depths, call.viewCount, images));
    }
    const auto readScene = [&](const SceneRead& read) { return backend.readScene(read, images[read.view]); };
    return preparePictures(scene, {side->renderer, backend}, call.slot,
                           {[&] { return begin(backend); }, [&] { return end(backend); }, depths != nullptr, readScene});
}

/** Reads a submission. InvalidArgument: a list or a handle is missing. */
Result<vk::AppSubmission> submissionOf(const DplVulkanSubmission& given) {
    if (given.waitCount > 0 && (!given.waits || !given.waitStages))
        return fail(Code::InvalidArgument, "waitCount of how is {}, but waits or waitStages is NULL", given.waitCount);
    if (given.signalCount > 0 && !given.signals)
        return fail(Code::InvalidArgument, "signalCount of how is {}, but signals is NULL", given.signalCount);
    vk::AppSubmission how;
    how.waits = {given.waits, given.waitCount}, how.waitStages = {given.waitStages, given.waitCount};
    how.signals = {given.signals, given.signalCount};
    if (given.waitValues) how.waitValues = {given.waitValues, given.waitCount};
    if (given.signalValues) how.signalValues = {given.signalValues, given.signalCount};
    how.fence = given.fence;
    for (size_t i = 0; i < how.waits.size(); ++i)
        if (!how.waits[i] || how.waitStages[i] == 0) return fail(Code::InvalidArgument, "wait {} of how has no semaphore or no stage", i);
    for (size_t i = 0; i < how.signals.size(); ++i)
        if (!how.signals[i]) return fail(Code::InvalidArgument, "signal {} of how has no semaphore", i);
    return how;
}

Result<vk::AppTargetDesc> targetOf(const DplVulkanTarget& given) {
    vk::AppTargetDesc desc;
    if (given.imageCount == 0 || given.imageCount > DPL_MAX_VIEWS || (given.viewMask != 0 && given.imageCount != 1))
        return fail(Code::InvalidArgument, "{} images with the view mask {}; one for each view is possible, or one with a mask",
                    given.imageCount, given.viewMask);
    for (uint32_t i = 0; i < given.imageCount; ++i)
        if (!(desc.images[i] = given.images[i])) return fail(Code::InvalidArgument, "image {} of target is null", i);
    if (given.widthPx == 0 || given.heightPx == 0)
        return fail(Code::InvalidArgument, "a target of {} x {} pixels", given.widthPx, given.heightPx);
    for (const VkImageLayout layout : {given.layoutBefore, given.layoutAfter})
        if (layout == VK_IMAGE_LAYOUT_UNDEFINED || layout == VK_IMAGE_LAYOUT_PREINITIALIZED)
            return fail(Code::InvalidArgument, "layoutBefore or layoutAfter of target is VkImageLayout {}, which keeps no pixels",
                        int(layout));
    desc.imageCount = given.imageCount;
    desc.extent = {given.widthPx, given.heightPx};
    desc.before = given.layoutBefore, desc.after = given.layoutAfter;
    desc.pass.colour = given.format, desc.pass.viewMask = given.viewMask;
    desc.pass.samples = given.samples == 0 ? 1 : given.samples;
    return desc;
}

/** Runs `body` with the Vulkan side of a context, whose mutex is locked. */
template <class Body>
DplResult withSide(const char* function, DplContext context, Body&& body) {
    return guarded(function, [&]() -> Status {
        DPL_TRY(const auto found, contextOf(context));
        std::lock_guard lock(found->mutex);
        DPL_TRY(VulkanSide * side, sideOf(*found));
        return body(side->backend, *found);
    });
}

}  // namespace
}  // namespace dpl::api

using namespace dpl;
using namespace dpl::api;

extern "C" DplResult dplGetVulkanRequirement(uint32_t index, DplVulkanRequirement* requirement) {
    return guarded("dplGetVulkanRequirement", [&]() -> Status {
        if (index >= std::size(kRequirements))
            return fail(Code::NotFound, "there is no requirement {}; there are {}", index, std::size(kRequirements));
        return writeStruct(requirement, kRequirements[index], "requirement");
    });
}

extern "C" DplResult dplCreateVulkanContext(const DplVulkanDevice* device, const DplContextInfo* info, DplContext* context) {
    return guarded("dplCreateVulkanContext", [&]() -> Status {
        if (context == nullptr) return fail(Code::InvalidArgument, "context is NULL");
        DPL_TRY(const DplVulkanDevice given, readStruct<DplVulkanDevice>(device, "device"));
        auto made = std::make_shared<Context>();
        DPL_TRY(made->request, readContextInfo(info));
        DPL_TRY(NewRenderer lent, lentRenderer(given, made->request.options));
        made->lent = true;
        made->vulkan = std::move(lent.side);
        made->renderer = std::move(lent.renderer);
        made->rendererName = made->renderer->name();
        *context = reinterpret_cast<DplContext>(contexts().add(std::move(made)));
        return {};
    });
}

extern "C" DplResult dplRebuildVulkan(DplContext context, const DplVulkanDevice* device) {
    return guarded("dplRebuildVulkan", [&]() -> Status {
        DPL_TRY(const auto found, contextOf(context));
        std::scoped_lock lock(found->loads, found->mutex);
        DPL_TRY(NewRenderer made, rebuilt(*found, device));
        found->rendererName = made.renderer->name();
        found->vulkan = std::move(made.side);
        found->renderer = std::move(made.renderer);
        return {};
    });
}

extern "C" DplResult dplCreateVulkanComposer(DplContext context, const DplVulkanPass* pass, uint32_t* composer) {
    return guarded("dplCreateVulkanComposer", [&]() -> Status {
        if (composer == nullptr) return fail(Code::InvalidArgument, "composer is NULL");
        DPL_TRY(const DplVulkanPass given, readStruct<DplVulkanPass>(pass, "pass"));
        if (given.writesDepth > DPL_DRAW_MESH_DEPTH)
            return fail(Code::InvalidArgument, "writesDepth of pass is {}; 0, DPL_DRAW_DEPTH and DPL_DRAW_MESH_DEPTH are possible",
                        given.writesDepth);
        DPL_TRY(const auto found, contextOf(context));
        std::lock_guard lock(found->mutex);
        DPL_TRY(VulkanSide * side, sideOf(*found));
        DPL_TRY(const ComposerId made, side->backend.createComposer(passOf(given)));
        *composer = made.value;
        return {};
    });
}

extern "C" DplResult dplDestroyVulkanComposer(DplContext context, uint32_t composer) {
    return withSide("dplDestroyVulkanComposer", context,
                    [&](vk::VulkanBackend& backend, const Context&) -> Status { return backend.destroyComposer({composer}); });
}

extern "C" DplResult dplVulkanPrepare(DplContext context, VkCommandBuffer commands, uint32_t slot, const DplAvatar* avatars,
                                      uint32_t avatarCount, const DplCamera* views, uint32_t viewCount, const DplVulkanSceneDepth* depths) {
    return guarded("dplVulkanPrepare", [&]() -> Status {
        if (!commands) return fail(Code::InvalidArgument, "commands is NULL");
        DPL_TRY(const auto set, together(avatars, avatarCount));
        const auto begin = [&](vk::VulkanBackend&) -> Result<AppCommands> { return AppCommands{commands}; };
        const auto end = [](vk::VulkanBackend&) { return Status(); };
        return prepare({context, slot, set, views, viewCount}, depths, begin, end);
    });
}

extern "C" DplResult dplCreateVulkanTarget(DplContext context, const DplVulkanTarget* desc, uint32_t* target) {
    return guarded("dplCreateVulkanTarget", [&]() -> Status {
        if (target == nullptr) return fail(Code::InvalidArgument, "target is NULL");
        DPL_TRY(const DplVulkanTarget given, readStruct<DplVulkanTarget>(desc, "desc"));
        DPL_TRY(const vk::AppTargetDesc wanted, targetOf(given));
        DPL_TRY(const auto found, contextOf(context));
        std::lock_guard lock(found->mutex);
        DPL_TRY(VulkanSide * side, sideOf(*found));
        DPL_TRY(const vk::AppTargetId made, side->backend.createAppTarget(wanted));
        *target = made.value;
        return {};
    });
}

extern "C" DplResult dplDestroyVulkanTarget(DplContext context, uint32_t target) {
    return withSide("dplDestroyVulkanTarget", context,
                    [&](vk::VulkanBackend& backend, const Context&) -> Status { return backend.destroyAppTarget({target}); });
}

extern "C" DplResult dplVulkanSubmit(DplContext context, uint32_t target, uint32_t slot, const DplAvatar* avatars, uint32_t avatarCount,
                                     const DplCamera* views, uint32_t viewCount, const DplVulkanSceneDepth* depths,
                                     const DplVulkanSubmission* how) {
    return guarded("dplVulkanSubmit", [&]() -> Status {
        DPL_TRY(const DplVulkanSubmission given, readStruct<DplVulkanSubmission>(how, "how"));
        DPL_TRY(const vk::AppSubmission submission, submissionOf(given));
        DPL_TRY(const auto set, together(avatars, avatarCount));
        const auto begin = [&](vk::VulkanBackend& backend) { return backend.beginSubmission({target}, slot, viewCount); };
        const auto end = [&](vk::VulkanBackend& backend) { return backend.submitTo({target}, slot, {given.x, given.y}, submission); };
        return prepare({context, slot, set, views, viewCount}, depths, begin, end);
    });
}

extern "C" DplResult dplVulkanUpload(DplContext context, VkCommandBuffer commands, uint32_t slot) {
    return withSide("dplVulkanUpload", context, [&](vk::VulkanBackend& backend, const Context& locked) -> Status {
        if (!commands) return fail(Code::InvalidArgument, "commands is NULL");
        return encodeUploads(locked, backend, slot, {commands});
    });
}

extern "C" DplResult dplVulkanWriteSplats(DplAvatar avatar, VkCommandBuffer commands, uint32_t slot, const DplSplatOptions* options,
                                          const DplVulkanBuffer* buffer, DplWritten* written) {
    return guarded("dplVulkanWriteSplats", [&]() -> Status {
        DPL_TRY(const SplatRequest request, requestOf(options));
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        DPL_TRY(VulkanSide * side, sideOf(*found->context));
        const AppSide app{side->renderer, side->backend};
        if (buffer == nullptr) return countSplats(app, *found, request, written);
        if (!commands) return fail(Code::InvalidArgument, "commands is NULL");
        DPL_TRY(const DplVulkanBuffer given, readStruct<DplVulkanBuffer>(buffer, "buffer"));
        if (!given.buffer) return fail(Code::InvalidArgument, "buffer of the buffer is NULL");
        const auto lend = [&](FrameId frame, BufferId rows, uint64_t offset, uint64_t bytes) {
            return side->backend.lend(frame, rows, given.buffer, offset, bytes);
        };
        return writeSplatsOnGpu(app, *found, request, {given.elements, given.elementCount, given.bytes}, {slot, {commands}, lend}, written);
    });
}

extern "C" DplResult dplVulkanDropSlot(DplContext context, uint32_t slot) {
    return withSide("dplVulkanDropSlot", context,
                    [&](vk::VulkanBackend& backend, const Context&) -> Status { return backend.dropSlot(slot); });
}

extern "C" DplResult dplVulkanCompose(DplContext context, uint32_t composer, VkCommandBuffer commands, uint32_t slot, uint32_t view,
                                      int32_t x, int32_t y) {
    return withSide("dplVulkanCompose", context, [&](vk::VulkanBackend& backend, const Context&) -> Status {
        if (!commands) return fail(Code::InvalidArgument, "commands is NULL");
        return backend.compose({composer}, slot, view, {x, y}, {commands});
    });
}

extern "C" DplResult dplVulkanComposeDepth(DplContext context, uint32_t composer, VkCommandBuffer commands, uint32_t slot, uint32_t view,
                                           int32_t x, int32_t y, float scale, float offset) {
    return withSide("dplVulkanComposeDepth", context, [&](vk::VulkanBackend& backend, const Context&) -> Status {
        if (!commands) return fail(Code::InvalidArgument, "commands is NULL");
        DPL_RETURN_IF_ERROR(checkProjection(scale, offset));
        return backend.composeDepth({composer}, slot, view, {x, y}, {scale, offset}, {commands});
    });
}
