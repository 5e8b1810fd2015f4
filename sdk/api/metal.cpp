// SPDX-License-Identifier: Apache-2.0
// Contexts on a program's own Metal device, and the frames that become part of the program's frames.
#include "sdk/include/doppel/doppel_metal.h"

#include "sdk/api/app_frame.h"
#include "sdk/api/create_renderer.h"
#include "sdk/api/write_on_gpu.h"
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::api {

/** What only a context on the program's device has. The context owns the renderer, which owns the backend. */
struct MetalSide {
    GpuRenderer& renderer;
    mtl::MetalBackend& backend;
};

namespace {

static_assert(DPL_METAL_SLOTS == kAppSlots && DPL_METAL_DEPTH_COVERAGE == gpu::kDepthCoverage && DPL_MAX_VIEWS == gpu::kMaxViews);

/** The Metal side of a context whose mutex is locked. */
Result<MetalSide*> sideOf(const Context& context) {
    DPL_RETURN_IF_ERROR(checkUsable(context));
    if (!context.metal)
        return fail(Code::InvalidArgument, "the context is not on the program's Metal device; make it with dplCreateMetalContext");
    return context.metal.get();
}

struct NewRenderer {
    std::unique_ptr<Renderer> renderer;
    std::shared_ptr<MetalSide> side;  // null: not on the program's device
};
/** On the program's device. */
Result<NewRenderer> lentRenderer(const DplMetalDevice& given, const RendererOptions& options) {
    if (given.reserved != 0) return fail(Code::InvalidArgument, "reserved of device is {}; it must be 0", given.reserved);
    DPL_TRY(auto backend, mtl::createBackendOn(given.device, given.queue));
    mtl::MetalBackend& lent = *backend;
    std::string name = "metal: " + lent.info().name;
    auto renderer = std::make_unique<GpuRenderer>(std::move(backend), std::move(name));
    DPL_RETURN_IF_ERROR(setFill(*renderer, options));
    auto side = std::make_shared<MetalSide>(MetalSide{*renderer, lent});
    return NewRenderer{std::move(renderer), std::move(side)};
}

/** A renderer on a new device, with the avatars of the context. The context's mutexes are locked. */
Result<NewRenderer> rebuilt(const Context& context, const DplMetalDevice* device) {
    if (!context.renderer) return fail(Code::InvalidArgument, "the context was destroyed");
    if (!drawsByMetal(*context.renderer))
        return fail(Code::InvalidArgument, "the context does not draw by Metal ({}): there is no Metal device to lose",
                    context.rendererName);
    if (context.metal && !device)
        return fail(Code::InvalidArgument, "device is NULL, but the context was made on a device of the program; give it, or a new one");
    if (!context.metal && device)
        return fail(Code::InvalidArgument, "the context was not made with dplCreateMetalContext; device must be NULL");
    NewRenderer made;
    if (device) {
        DPL_TRY(const DplMetalDevice given, readStruct<DplMetalDevice>(device, "device"));
        DPL_TRY(made, lentRenderer(given, context.request.options));
        made.side->backend.numberAfter(context.metal->backend.lastNumber());
    } else {
        DPL_TRY(made.renderer, createGpuRenderer(context.request.kind, context.request.options));
    }
    DPL_RETURN_IF_ERROR(made.renderer->addAll(*context.renderer));
    return made;
}

mtl::AppPass passOf(const DplMetalPass& given) {
    mtl::AppPass pass;
    pass.colour = mtl::PixelFormat(given.colourFormat);
    pass.depth = mtl::PixelFormat(given.depthFormat), pass.stencil = mtl::PixelFormat(given.stencilFormat);
    pass.samples = given.samples == 0 ? 1 : given.samples;
    pass.layers = given.layers;
    pass.written = PictureDepth(given.writesDepth);
    return pass;
}

/** Reads the depths of a call. textures: viewCount of them. */
Status takeDepths(const mtl::MetalBackend& backend, const DplMetalSceneDepth* depths, uint32_t viewCount, mtl::SceneTexture* textures) {
    for (uint32_t v = 0; v < viewCount; ++v) {
        DPL_TRY(const DplMetalSceneDepth given, element(depths, v, "depths"));
        if (!given.texture) return fail(Code::InvalidArgument, "depth {} has no texture", v);
        DPL_RETURN_IF_ERROR(checkProjection(given.scale, given.offset));
        textures[v] = {{given.texture}, {given.slice, given.x, given.y, {given.scale, given.offset}}};
        DPL_RETURN_IF_ERROR(backend.checkScene(v, textures[v]));
    }
    return {};
}

Status prepare(const PictureCall& call, const DplMetalSceneDepth* depths, FunctionRef<Result<AppCommands>(mtl::MetalBackend&)> begin,
               FunctionRef<Status(mtl::MetalBackend&)> end) {
    DPL_TRY(Scene scene, sceneOf(call.context, call.avatars, call.viewCount));
    DPL_TRY(MetalSide * side, sideOf(*scene.context));
    mtl::MetalBackend& backend = side->backend;
    DPL_RETURN_IF_ERROR(takeViews(scene, call.views, call.viewCount));
    mtl::SceneTexture textures[DPL_MAX_VIEWS];
    if (depths) {
        DPL_RETURN_IF_ERROR(takeDepths(backend, depths, call.viewCount, textures));
    }
    const auto readScene = [&](const SceneRead& read) { return backend.readScene(read, textures[read.view]); };
    return preparePictures(scene, {side->renderer, backend}, call.slot,
                           {[&] { return begin(backend); }, [&] { return end(backend); }, depths != nullptr, readScene});
}

Result<mtl::AppSubmission> submissionOf(const DplMetalSubmission& given) {
    if (given.textureCount == 0 || given.textureCount > DPL_MAX_VIEWS)
        return fail(Code::InvalidArgument, "textureCount of how is {}; 1 to {} are possible", given.textureCount, DPL_MAX_VIEWS);
    mtl::AppSubmission how;
    how.textureCount = given.textureCount;
    for (uint32_t i = 0; i < given.textureCount; ++i) {
        if (!given.textures[i]) return fail(Code::InvalidArgument, "texture {} of how is NULL", i);
        how.textures[i] = {given.textures[i]};
    }
    how.place = {given.x, given.y};
    how.waitEvent = {given.waitEvent}, how.signalEvent = {given.signalEvent};
    how.waitValue = given.waitValue, how.signalValue = given.signalValue;
    how.drawable = {given.drawable};
    return how;
}

/** Runs `body` with the Metal side of a context, whose mutex is locked. */
template <class Body>
DplResult withSide(const char* function, DplContext context, Body&& body) {
    return guarded(function, [&]() -> Status {
        DPL_TRY(const auto found, contextOf(context));
        std::lock_guard lock(found->mutex);
        DPL_TRY(MetalSide * side, sideOf(*found));
        return body(side->backend, *found);
    });
}

}  // namespace
}  // namespace dpl::api

using namespace dpl;
using namespace dpl::api;

extern "C" DplResult dplCreateMetalContext(const DplMetalDevice* device, const DplContextInfo* info, DplContext* context) {
    return guarded("dplCreateMetalContext", [&]() -> Status {
        if (context == nullptr) return fail(Code::InvalidArgument, "context is NULL");
        DPL_TRY(const DplMetalDevice given, readStruct<DplMetalDevice>(device, "device"));
        auto made = std::make_shared<Context>();
        DPL_TRY(made->request, readContextInfo(info));
        DPL_TRY(NewRenderer lent, lentRenderer(given, made->request.options));
        made->lent = true;
        made->metal = std::move(lent.side);
        made->renderer = std::move(lent.renderer);
        made->rendererName = made->renderer->name();
        *context = reinterpret_cast<DplContext>(contexts().add(std::move(made)));
        return {};
    });
}

extern "C" DplResult dplRebuildMetal(DplContext context, const DplMetalDevice* device) {
    return guarded("dplRebuildMetal", [&]() -> Status {
        DPL_TRY(const auto found, contextOf(context));
        std::scoped_lock lock(found->loads, found->mutex);
        DPL_TRY(NewRenderer made, rebuilt(*found, device));
        found->rendererName = made.renderer->name();
        found->metal = std::move(made.side);
        found->renderer = std::move(made.renderer);
        return {};
    });
}

extern "C" DplResult dplCreateMetalComposer(DplContext context, const DplMetalPass* pass, uint32_t* composer) {
    return withSide("dplCreateMetalComposer", context, [&](mtl::MetalBackend& backend, const Context&) -> Status {
        if (composer == nullptr) return fail(Code::InvalidArgument, "composer is NULL");
        DPL_TRY(const DplMetalPass given, readStruct<DplMetalPass>(pass, "pass"));
        if (given.writesDepth > DPL_DRAW_MESH_DEPTH)
            return fail(Code::InvalidArgument, "writesDepth of pass is {}; 0, DPL_DRAW_DEPTH and DPL_DRAW_MESH_DEPTH are possible",
                        given.writesDepth);
        DPL_TRY(const ComposerId made, backend.createComposer(passOf(given)));
        *composer = made.value;
        return {};
    });
}

extern "C" DplResult dplDestroyMetalComposer(DplContext context, uint32_t composer) {
    return withSide("dplDestroyMetalComposer", context,
                    [&](mtl::MetalBackend& backend, const Context&) -> Status { return backend.destroyComposer({composer}); });
}

extern "C" DplResult dplMetalPrepare(DplContext context, void* commands, uint32_t slot, const DplAvatar* avatars, uint32_t avatarCount,
                                     const DplCamera* views, uint32_t viewCount, const DplMetalSceneDepth* depths) {
    return guarded("dplMetalPrepare", [&]() -> Status {
        if (!commands) return fail(Code::InvalidArgument, "commands is NULL");
        DPL_TRY(const auto set, together(avatars, avatarCount));
        const auto begin = [&](mtl::MetalBackend&) -> Result<AppCommands> { return AppCommands{commands}; };
        const auto end = [](mtl::MetalBackend&) { return Status(); };
        return prepare({context, slot, set, views, viewCount}, depths, begin, end);
    });
}

extern "C" DplResult dplMetalSubmit(DplContext context, uint32_t composer, uint32_t slot, const DplAvatar* avatars, uint32_t avatarCount,
                                    const DplCamera* views, uint32_t viewCount, const DplMetalSceneDepth* depths,
                                    const DplMetalSubmission* how) {
    return guarded("dplMetalSubmit", [&]() -> Status {
        DPL_TRY(const DplMetalSubmission given, readStruct<DplMetalSubmission>(how, "how"));
        DPL_TRY(const mtl::AppSubmission submission, submissionOf(given));
        DPL_TRY(const auto set, together(avatars, avatarCount));
        const auto begin = [&](mtl::MetalBackend& backend) { return backend.beginSubmission({composer}, slot, viewCount, submission); };
        const auto end = [&](mtl::MetalBackend& backend) { return backend.submitTo({composer}, slot, submission); };
        return prepare({context, slot, set, views, viewCount}, depths, begin, end);
    });
}

extern "C" DplResult dplMetalUpload(DplContext context, void* commands, uint32_t slot) {
    return withSide("dplMetalUpload", context, [&](mtl::MetalBackend& backend, const Context& locked) -> Status {
        if (!commands) return fail(Code::InvalidArgument, "commands is NULL");
        return encodeUploads(locked, backend, slot, {commands});
    });
}

extern "C" DplResult dplMetalWriteSplats(DplAvatar avatar, void* commands, uint32_t slot, const DplSplatOptions* options,
                                         const DplMetalBuffer* buffer, DplWritten* written) {
    return guarded("dplMetalWriteSplats", [&]() -> Status {
        DPL_TRY(const SplatRequest request, requestOf(options));
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        DPL_TRY(MetalSide * side, sideOf(*found->context));
        const AppSide app{side->renderer, side->backend};
        if (buffer == nullptr) return countSplats(app, *found, request, written);
        if (!commands) return fail(Code::InvalidArgument, "commands is NULL");
        DPL_TRY(const DplMetalBuffer given, readStruct<DplMetalBuffer>(buffer, "buffer"));
        if (!given.buffer) return fail(Code::InvalidArgument, "buffer of the buffer is NULL");
        const auto lend = [&](FrameId, BufferId rows, uint64_t offset, uint64_t) {
            return side->backend.lend(rows, {given.buffer}, offset);
        };
        return writeSplatsOnGpu(app, *found, request, {given.elements, given.elementCount, given.bytes}, {slot, {commands}, lend}, written);
    });
}

extern "C" DplResult dplMetalDropSlot(DplContext context, uint32_t slot) {
    return withSide("dplMetalDropSlot", context,
                    [&](mtl::MetalBackend& backend, const Context&) -> Status { return backend.dropSlot(slot); });
}

extern "C" DplResult dplMetalCompose(DplContext context, uint32_t composer, void* encoder, uint32_t slot, uint32_t view, int32_t x,
                                     int32_t y) {
    return withSide("dplMetalCompose", context, [&](mtl::MetalBackend& backend, const Context&) -> Status {
        if (!encoder) return fail(Code::InvalidArgument, "encoder is NULL");
        return backend.compose({composer}, slot, view, {x, y}, {encoder});
    });
}

extern "C" DplResult dplMetalComposeDepth(DplContext context, uint32_t composer, void* encoder, uint32_t slot, uint32_t view, int32_t x,
                                          int32_t y, float scale, float offset) {
    return withSide("dplMetalComposeDepth", context, [&](mtl::MetalBackend& backend, const Context&) -> Status {
        if (!encoder) return fail(Code::InvalidArgument, "encoder is NULL");
        DPL_RETURN_IF_ERROR(checkProjection(scale, offset));
        return backend.composeDepth({composer}, slot, view, {x, y}, {scale, offset}, {encoder});
    });
}
