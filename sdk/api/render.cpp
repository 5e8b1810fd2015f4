// SPDX-License-Identifier: Apache-2.0
// Drawing: checks the caller's structs and buffers, draws, and copies the pictures into the caller's memory.
#include <algorithm>
#include <cmath>

#include "sdk/api/api_state.h"
#include "sdk/api/compose.h"
#include "sdk/api/frame_stats.h"
#include "sdk/api/scene.h"
#include "sdk/include/doppel/doppel_splats.h"

using namespace dpl;
using namespace dpl::api;

namespace {

/** A frame of an app counts as running again once its slot was prepared anew, so what was seen before is kept. */
const FrameTiming& timingOf(const Context& context, Avatar& first) {
    const FrameTiming now = context.renderer->timing(first.renderId);
    if (now.frame > 0) first.timing = now;
    first.timing.last = now.last;
    return first.timing;
}

}  // namespace

void dpl::api::setDetailOfDraw(Context& context, Avatar& first) {
    DetailOptions detail = context.detail;
    // Only a budget asks for the time of every frame: lavapipe waits for the GPU before it tells a timestamp.
    detail.limits = first.governor.next(context.frameBudgetMs, context.frameBudgetMs > 0 ? timingOf(context, first) : FrameTiming());
    context.renderer->setDetail(detail);
}

namespace {

static_assert(DPL_BUDGET_OFF == int(BudgetState::Off) && DPL_BUDGET_UNTIMED == int(BudgetState::Untimed) &&
              DPL_BUDGET_FREE == int(BudgetState::Free) && DPL_BUDGET_LIMITED == int(BudgetState::Limited) &&
              DPL_BUDGET_UNREACHABLE == int(BudgetState::Unreachable));

Status checkImage(const DplImage& image, size_t width, size_t height, size_t view) {
    const uint32_t flags = image.flags;
    if (flags & ~uint32_t(DPL_IMAGE_STRAIGHT_ALPHA | DPL_IMAGE_OVER))
        return fail(Code::InvalidArgument, "image {} has unknown flags {}", view, flags);
    if ((flags & DPL_IMAGE_STRAIGHT_ALPHA) && (flags & DPL_IMAGE_OVER))
        return fail(Code::InvalidArgument,
                    "image {} has both DPL_IMAGE_OVER and DPL_IMAGE_STRAIGHT_ALPHA; only premultiplied pixels can be drawn over", view);
    if (const auto format = uint32_t(image.format); format > DPL_FORMAT_RGBA16F)
        return fail(Code::InvalidArgument, "image {}: there is no format {}", view, format);
    if (image.rgba == nullptr && image.depthM == nullptr && image.meshDepthM == nullptr)
        return fail(Code::InvalidArgument, "image {} has neither rgba nor depthM nor meshDepthM", view);
    if (image.rgba != nullptr) {
        const size_t tight = width * pixelBytes(image.format), row = image.rowBytes == 0 ? tight : image.rowBytes;
        if (row < tight) return fail(Code::InvalidArgument, "image {} has rows of {} bytes; {} pixels need {}", view, row, width, tight);
        if (row > image.rgbaBytes / height)
            return fail(Code::InvalidArgument, "image {} has {} bytes; {} rows of {} need more", view, image.rgbaBytes, height, row);
    }
    if (image.depthM != nullptr && image.depthCount < width * height)
        return fail(Code::InvalidArgument, "image {} has room for {} depths; {} are needed", view, image.depthCount, width * height);
    if (image.meshDepthM != nullptr && image.meshDepthCount < width * height)
        return fail(Code::InvalidArgument, "image {} has room for {} depths of the mesh; {} are needed", view, image.meshDepthCount,
                    width * height);
    return {};
}

void copyOut(const PixelView& from, const DplImage& to) {
    const size_t width = from.widthPx, height = from.heightPx, row = to.rowBytes == 0 ? width * pixelBytes(to.format) : to.rowBytes;
    const Composition how{to.format, (to.flags & DPL_IMAGE_OVER) != 0, (to.flags & DPL_IMAGE_STRAIGHT_ALPHA) != 0};
    for (size_t y = 0; y < height && to.rgba != nullptr; ++y) composeRow(from.rgba.data() + y * width * 4, width, how, to.rgba + y * row);
    if (to.depthM != nullptr) std::memcpy(to.depthM, from.depthM.data(), width * height * sizeof(float));
    if (to.meshDepthM != nullptr) std::memcpy(to.meshDepthM, from.meshDepthM.data(), width * height * sizeof(float));
}

/** Copies the caller's images to `targets`, checks them, and fills `wants`. targets: viewCount of them. */
Status takeImages(const DplImage* images, uint32_t viewCount, size_t widthPx, size_t heightPx, DplImage* targets, FrameWants& wants) {
    wants = {};
    for (uint32_t v = 0; v < viewCount; ++v) {
        DPL_TRY(targets[v], element(images, v, "images", offsetof(DplImage, format)));
        DPL_RETURN_IF_ERROR(checkImage(targets[v], widthPx, heightPx, v));
        wants.depth |= targets[v].depthM != nullptr;
        wants.meshDepth |= targets[v].meshDepthM != nullptr;
    }
    return {};
}

Status drawTaken(Scene& s, FrameWants wants) {
    std::copy(std::begin(s.sceneDepthM), std::end(s.sceneDepthM), wants.sceneDepthM);
    Avatar& a = s.first();
    const std::vector<Cameraf>& cameras = s.context->cameras;
    a.drawnViews = 0;
    Drawn what[DPL_MAX_TOGETHER];
    setDetailOfDraw(*s.context, a);
    DPL_RETURN_IF_ERROR(s.context->renderer->drawTogether(s.drawn(what), cameras, wants));
    a.drawnViews = uint32_t(cameras.size()), a.drawnWidthPx = cameras[0].widthPx, a.drawnHeightPx = cameras[0].heightPx;
    a.drawnDepth = wants.depth, a.drawnMeshDepth = wants.meshDepth;
    return {};
}

Status readInto(Scene& s, const DplImage* targets) {
    DPL_TRY(const std::span<const PixelView> pixels, s.context->renderer->read(s.first().renderId));
    for (size_t v = 0; v < pixels.size(); ++v) copyOut(pixels[v], targets[v]);
    return {};
}

Status render(DplContext context, std::span<const DplAvatar> avatars, const DplCamera* views, uint32_t viewCount, const DplImage* images) {
    DPL_TRY(Scene scene, sceneOf(context, avatars, viewCount));
    DPL_RETURN_IF_ERROR(takeViews(scene, views, viewCount));
    DplImage targets[DPL_MAX_VIEWS];
    FrameWants wants;
    const Cameraf& first = scene.context->cameras[0];
    DPL_RETURN_IF_ERROR(takeImages(images, viewCount, first.widthPx, first.heightPx, targets, wants));
    DPL_RETURN_IF_ERROR(drawTaken(scene, wants));
    return readInto(scene, targets);
}

Status draw(DplContext context, std::span<const DplAvatar> avatars, const DplCamera* views, uint32_t viewCount, uint32_t flags) {
    if (flags & ~uint32_t(DPL_DRAW_DEPTH | DPL_DRAW_MESH_DEPTH)) return fail(Code::InvalidArgument, "unknown flags {}", flags);
    DPL_TRY(Scene scene, sceneOf(context, avatars, viewCount));
    DPL_RETURN_IF_ERROR(takeViews(scene, views, viewCount));
    FrameWants wants;
    wants.depth = (flags & DPL_DRAW_DEPTH) != 0;
    wants.meshDepth = (flags & DPL_DRAW_MESH_DEPTH) != 0;
    return drawTaken(scene, wants);
}

static_assert(sizeof(DplScreenSplat) == sizeof(ScreenSplat) && offsetof(DplScreenSplat, depthM) == offsetof(ScreenSplat, depthM) &&
              offsetof(DplScreenSplat, slope) == offsetof(ScreenSplat, slope) &&
              offsetof(DplScreenSplat, inverseVarianceY) == offsetof(ScreenSplat, inverseVarianceY) &&
              offsetof(DplScreenSplat, opacity) == offsetof(ScreenSplat, opacity));

Status project(DplContext context, std::span<const DplAvatar> avatars, const DplCamera* views, uint32_t viewCount, DplScreenSplat* splats,
               uint32_t capacity, DplProjection* projection) {
    if (splats == nullptr && capacity > 0) return fail(Code::InvalidArgument, "splats is NULL");
    DPL_TRY(Scene scene, sceneOf(context, avatars, viewCount));
    DPL_RETURN_IF_ERROR(takeViews(scene, views, viewCount));
    DPL_RETURN_IF_ERROR(readStruct<DplProjection>(projection, "projection"));
    Avatar& a = scene.first();
    a.drawnViews = 0;
    Drawn what[DPL_MAX_TOGETHER];
    setDetailOfDraw(*scene.context, a);
    DPL_TRY(const ScreenSplats made, scene.context->renderer->projectTogether(scene.drawn(what), scene.context->cameras,
                                                                              {reinterpret_cast<ScreenSplat*>(splats), capacity}));
    DplProjection out{};
    std::copy(std::begin(made.counts), std::end(made.counts), out.counts);
    out.samples = made.samples;
    return writeStruct(projection, out, "projection");
}

}  // namespace

extern "C" DplResult dplRender(DplContext context, DplAvatar avatar, const DplCamera* views, uint32_t viewCount, const DplImage* images) {
    return guarded("dplRender", [&] { return render(context, {&avatar, 1}, views, viewCount, images); });
}

extern "C" DplResult dplDraw(DplContext context, DplAvatar avatar, const DplCamera* views, uint32_t viewCount, uint32_t flags) {
    return guarded("dplDraw", [&] { return draw(context, {&avatar, 1}, views, viewCount, flags); });
}

extern "C" DplResult dplRenderTogether(DplContext context, const DplAvatar* avatars, uint32_t avatarCount, const DplCamera* views,
                                       uint32_t viewCount, const DplImage* images) {
    return guarded("dplRenderTogether", [&]() -> Status {
        DPL_TRY(const auto set, together(avatars, avatarCount));
        return render(context, set, views, viewCount, images);
    });
}

extern "C" DplResult dplDrawTogether(DplContext context, const DplAvatar* avatars, uint32_t avatarCount, const DplCamera* views,
                                     uint32_t viewCount, uint32_t flags) {
    return guarded("dplDrawTogether", [&]() -> Status {
        DPL_TRY(const auto set, together(avatars, avatarCount));
        return draw(context, set, views, viewCount, flags);
    });
}

extern "C" DplResult dplProject(DplContext context, const DplAvatar* avatars, uint32_t avatarCount, const DplCamera* views,
                                uint32_t viewCount, DplScreenSplat* splats, uint32_t capacity, DplProjection* projection) {
    return guarded("dplProject", [&]() -> Status {
        DPL_TRY(const auto set, together(avatars, avatarCount));
        return project(context, set, views, viewCount, splats, capacity, projection);
    });
}

extern "C" DplResult dplReadImages(DplContext context, DplAvatar avatar, const DplImage* images, uint32_t viewCount) {
    return guarded("dplReadImages", [&]() -> Status {
        DPL_TRY(Scene scene, sceneOf(context, {&avatar, 1}, viewCount));
        const Avatar& a = scene.first();
        if (a.drawnViews == 0) return fail(Code::InvalidArgument, "nothing was drawn yet; call dplDraw first");
        if (a.drawnViews != viewCount)
            return fail(Code::InvalidArgument, "viewCount is {}, but the frame has {} views", viewCount, a.drawnViews);
        DplImage targets[DPL_MAX_VIEWS];
        FrameWants wants;
        DPL_RETURN_IF_ERROR(takeImages(images, viewCount, a.drawnWidthPx, a.drawnHeightPx, targets, wants));
        if (wants.meshDepth && !a.drawnMeshDepth)
            return fail(Code::InvalidArgument, "depth of the mesh was not drawn; give dplDraw the flag DPL_DRAW_MESH_DEPTH");
        if (wants.depth && !a.drawnDepth) return fail(Code::InvalidArgument, "depth was not drawn; give dplDraw the flag DPL_DRAW_DEPTH");
        return readInto(scene, targets);
    });
}

extern "C" DplResult dplSetDetail(DplContext context, const DplDetail* detail) {
    return guarded("dplSetDetail", [&]() -> Status {
        DetailOptions wanted;
        if (detail != nullptr) {
            DPL_TRY(const DplDetail given, readStruct<DplDetail>(detail, "detail"));
            if (!(given.splatsPerPixel >= 0 && std::isfinite(given.splatsPerPixel)))
                return fail(Code::InvalidArgument, "{} splats a pixel; 0 (no level of detail) or a finite number above it is possible",
                            given.splatsPerPixel);
            wanted = {given.splatsPerPixel, given.splatBudget};
        }
        DPL_TRY(const auto found, contextOf(context));
        std::lock_guard lock(found->mutex);
        if (!found->renderer) return fail(Code::InvalidArgument, "the context was destroyed");
        found->detail = wanted;
        return {};
    });
}

extern "C" DplResult dplSetFrameBudget(DplContext context, double milliseconds) {
    return guarded("dplSetFrameBudget", [&]() -> Status {
        if (!(milliseconds >= 0 && std::isfinite(milliseconds)))
            return fail(Code::InvalidArgument, "a frame budget of {} ms; 0 (no budget) or a finite number above it is possible",
                        milliseconds);
        DPL_TRY(const auto found, contextOf(context));
        std::lock_guard lock(found->mutex);
        if (!found->renderer) return fail(Code::InvalidArgument, "the context was destroyed");
        found->frameBudgetMs = milliseconds;
        return {};
    });
}

extern "C" DplResult dplGetFrameStats(DplAvatar avatar, DplFrameStats* stats) {
    return guarded("dplGetFrameStats", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        std::lock_guard lock(found->context->mutex);
        if (!found->context->renderer) return fail(Code::InvalidArgument, "the context was destroyed");
        DPL_TRY(found->stats, found->context->renderer->stats(found->renderId));
        DplFrameStats out = publicStats(found->stats);
        const FrameTiming& timing = timingOf(*found->context, *found);
        out.frameMs = timing.ms;
        out.keptWanted = uint32_t(std::min<uint64_t>(timing.last.wantedKept, UINT32_MAX));
        out.keptLimit = found->governor.limits().kept;
        out.framesOver = found->governor.framesOver();
        out.budgetState = DplBudgetState(int(found->governor.state()));
        return writeStruct(stats, out, "stats", offsetof(DplFrameStats, avatarBytes));
    });
}

extern "C" DplResult dplGetPassTime(DplAvatar avatar, uint32_t pass, DplPassTime* time) {
    return guarded("dplGetPassTime", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        std::lock_guard lock(found->context->mutex);
        const std::vector<PassTime>& passes = found->stats.passes;
        if (pass >= passes.size()) return fail(Code::NotFound, "there is no pass {}; dplGetFrameStats found {}", pass, passes.size());
        DplPassTime out{};
        out.label = passes[pass].label.c_str();
        out.milliseconds = passes[pass].milliseconds;
        return writeStruct(time, out, "time");
    });
}
