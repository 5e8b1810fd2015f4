// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/gpu_renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "sdk/draw/check_draw.h"
#include "sdk/math/coverage.h"
#include "sdk/math/scene_depth.h"

namespace dpl {
namespace {

constexpr float kSharedOrderRad = 0.035f;  // 2 degrees; views further apart are sorted one by one (docs/reference/gpu-frame.md)

/** Whether one order of depth, along the mean axis, is good enough for all views. It is exact for parallel axes. */
bool shareOrder(std::span<const Cameraf> views) {
    const auto forward = [](const Cameraf& c) { return glm::transpose(c.viewFromWorldRotation) * Vec3f(0, 0, 1); };
    const Vec3f first = forward(views.front()), last = forward(views.back());
    return std::atan2(glm::length(glm::cross(first, last)), glm::dot(first, last)) <= kSharedOrderRad;
}

}  // namespace

GpuRenderer::GpuRenderer(std::unique_ptr<Backend> backend, std::string name, Fill fill)
    : backend_(std::move(backend)),
      name_(std::move(name)),
      fill_(fill),
      store_(*backend_),
      reader_(*backend_),
      cache_(*backend_, store_, [this](const RecordedFrame& frame) { reader_.forget(frame); }),
      writer_(*backend_, store_) {}

Result<std::unique_ptr<PreparedSubject>> GpuRenderer::prepareAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) const {
    return store_.prepareAvatar(std::move(avatar), std::move(splats));
}

Result<std::unique_ptr<PreparedSubject>> GpuRenderer::prepareSplats(const StaticSplatData& splats) const {
    return store_.prepareSplats(splats);
}

Result<RenderAvatarId> GpuRenderer::begin(std::unique_ptr<PreparedSubject> subject) {
    DPL_TRY(const RenderAvatarId id, store_.begin(std::move(subject)));
    if (const Status prepared = prepareFrames(id); !prepared) {
        store_.remove(id);
        return prepared.error();
    }
    return id;
}

Status GpuRenderer::addAll(const Renderer& other) {
    const auto* from = dynamic_cast<const GpuRenderer*>(&other);
    if (!from) return Renderer::addAll(other);
    DPL_RETURN_IF_ERROR(store_.addAll(from->store_));
    for (const auto& [id, subject] : store_.all()) {
        DPL_RETURN_IF_ERROR(prepareFrames(id));
    }
    frameNumber_ = from->frameNumber_;
    waits_ = from->waits_;
    return {};
}

/** Creates the lists for frames of an uploaded subject alone. */
Status GpuRenderer::prepareFrames(RenderAvatarId id) {
    const auto set = cache_.sceneSet({&id, 1});
    if (!set) return set.error();
    lastDraws_.emplace(id, LastDraw{});
    return {};
}

void GpuRenderer::removeAvatar(RenderAvatarId id) {
    cache_.remove(id);
    writer_.remove(id);
    store_.remove(id);
    lastDraws_.erase(id);
}

Status GpuRenderer::drawTogether(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) {
    return drawOrEncode(what, views, wants, nullptr);
}

Result<std::span<const EncodedView>> GpuRenderer::encodeTogether(std::span<const Drawn> what, std::span<const Cameraf> views,
                                                                 const FrameWants& wants, const AppFrame& app) {
    if (app.slot >= kAppSlots) return fail(Code::InvalidArgument, "slot {} does not exist; there are {}", app.slot, kAppSlots);
    encodedCount_ = 0;
    DPL_RETURN_IF_ERROR(drawOrEncode(what, views, wants, &app));
    return std::span<const EncodedView>(encoded_, encodedCount_);
}

Status GpuRenderer::drawOrEncode(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants,
                                 const AppFrame* app) {
    DPL_RETURN_IF_ERROR(checkDraw(what, views, wants, [this](RenderAvatarId id) { return store_.jointsOf(id); }));
    LoadedSubject* subjects[kMaxDrawnTogether];
    RenderAvatarId ids[kMaxDrawnTogether];
    for (size_t k = 0; k < what.size(); ++k) {
        ids[k] = what[k].avatar;
        subjects[k] = store_.find(ids[k]);
    }
    const bool shared = views.size() == 1 || shareOrder(views);
    const DrawCall call{what, {subjects, what.size()}, {views, shared}, wants, app};
    DPL_TRY(SceneSet * set, cache_.sceneSet({ids, what.size()}));
    const bool cullComponents = !wants.meshDepth;  // mesh depth needs every triangle that is not hidden
    const PosedSet posed = poser_.pose(what, call.subjects, call.views, detail_, cullComponents);
    for (size_t k = 0; k < what.size(); ++k) lastDraws_.at(ids[k]).drawnShare = posed.subjects[k].drawnShare;
    LastDraw& last = lastDraws_.at(ids[0]);
    last.set = 0;
    DPL_RETURN_IF_ERROR(drawFrames(*set, call, posed, last));
    last.set = set->number;
    last.encoded = app != nullptr;
    last.splats = posed.splats;
    return {};
}

/** The shape of the frames of a draw; `eye` is that of the first. */
FrameShape GpuRenderer::shapeOf(const DrawCall& call) const {
    FrameShape shape;
    const std::span<const Cameraf> views = call.views.all;
    shape.widthPx = views[0].widthPx;
    shape.heightPx = views[0].heightPx;
    shape.views = uint32_t(call.views.of(0).size());
    shape.depth = call.wants.depth;
    shape.meshDepth = call.wants.meshDepth;
    shape.sceneDepth = call.wants.behindScene();
    shape.encoded = call.app != nullptr;
    float kappaPx2 = INFINITY;
    for (size_t k = 0; k < call.what.size(); ++k) {
        const LoadedSubject& subject = *call.subjects[k];
        const Drawn& drawn = call.what[k];
        kappaPx2 = std::min(kappaPx2, subject.splats.kappaPx2);
        if (subject.avatar && backend_->info().fourSamples)
            shape.samples =
                std::max(shape.samples, coverageSamples(subject.avatar->trainedPixelM, rootPosition(subject.avatar->joints, *drawn.pose),
                                                        SubjectViews(drawn.placement, views).cameras()));
    }
    // The limit was derived for one sample. It also holds for four, which have κ/4 each but lower tiles (kTileMinKappaPx2).
    shape.fill = kappaPx2 >= kTileMinKappaPx2 ? fill_ : Fill::Quads;
    return shape;
}

Status GpuRenderer::drawFrames(SceneSet& set, const DrawCall& call, const PosedSet& posed, LastDraw& last) {
    FrameShape shape = shapeOf(call);
    last.frameCount = call.views.frameCount();
    for (; shape.eye < last.frameCount; ++shape.eye) {
        DPL_TRY(last.numbers[shape.eye], drawFrame(set, call, posed, shape));
    }
    return {};
}

/** Fills and submits the next slot, or encodes the app's slot, and returns the number of the frame. */
Result<uint64_t> GpuRenderer::drawFrame(SceneSet& set, const DrawCall& call, const PosedSet& posed, const FrameShape& shape) {
    DPL_TRY(RecordedFrame * frame, cache_.frame(set, shape, [&](const TargetDesc& desc) { return FrameTarget::create(*backend_, desc); }));
    FrameSlot& slot = frame->slots[call.app ? call.app->slot : frame->next];
    if (!call.app && !backend_->finished(slot.recorded)) {  // all slots are still running
        ++waits_;
        DPL_RETURN_IF_ERROR(backend_->wait(slot.recorded));
    }
    if (call.app) reader_.keepFinished(slot);
    fillSlot(slot, set, call, posed, shape);
    if (shape.sceneDepth && !call.wants.sceneEncoded) writeScene(slot, call, shape);
    DPL_RETURN_IF_ERROR(call.app ? encode(*frame, slot, *call.app, call.wants.sceneEncoded) : submit(*frame, slot));
    slot.last.number = frame->lastUse = set.lastUse = ++frameNumber_;
    return slot.last.number;
}

Status GpuRenderer::submit(RecordedFrame& frame, FrameSlot& slot) {
    DPL_RETURN_IF_ERROR(backend_->submit(slot.recorded));
    frame.next = (frame.next + 1) % kFramesInFlight;
    return {};
}

Status GpuRenderer::encode(const RecordedFrame& frame, const FrameSlot& slot, const AppFrame& app, bool withScene) {
    if (withScene) {
        DPL_RETURN_IF_ERROR(app.encodeScene(slot.scene, uint32_t(encodedCount_), frame.shape.views));
    }
    DPL_RETURN_IF_ERROR(backend_->encode(slot.recorded, app.slot, app.commands));
    for (uint32_t view = 0; view < frame.shape.views; ++view)
        encoded_[encodedCount_++] = {frame.ids.widthPx,    frame.ids.heightPx,    frame.ids.target,   view,
                                     frame.ids.tilePixels, frame.tileDepthOffset, frame.ids.meshDepth};
    return {};
}

/** Writes the uniform block and the palette of each subject. */
void GpuRenderer::fillSlot(FrameSlot& slot, const SceneSet& set, const DrawCall& call, const PosedSet& posed, const FrameShape& shape) {
    slot.last.componentsInView = 0;
    slot.last.splatsAllowed = posed.splats.drawn;
    slot.last.endsDraw = shape.eye + 1 == call.views.frameCount();
    for (size_t k = 0; k < call.subjects.size(); ++k) {
        const LoadedSubject& subject = *call.subjects[k];
        const DrawnSubject& pose = posed.subjects[k];
        const FrameSlot::Upload& upload = slot.uploads[k];
        uint32_t unseen = pose.unseen[shape.eye];
        slot.last.componentsInView += subject.components.count() - uint32_t(std::popcount(unseen));
        if (unseen != 0 && unseen == subject.components.all()) unseen = ~0u;  // vertices of no component count as unseen too
        if (subject.avatar)
            packPalette(pose.worldFromRest, pose.nodes, subject.avatar->light,
                        {reinterpret_cast<gpu::vec4*>(backend_->mapped(upload.palette).data()), subject.paletteSize});
        gpu::FrameData block = packFrame(subject.splats, call.views.of(shape.eye), shape.samples, pose.detail, pose.largestGrowth, unseen,
                                         call.what[k].placement);
        block.splatCount = set.ids.allSplats;
        if (!subject.avatar) packGeneralDetail(pose.generalDetail, block);
        std::memcpy(backend_->mapped(upload.frame).data(), &block, sizeof(block));
    }
}

void GpuRenderer::writeScene(const FrameSlot& slot, const DrawCall& call, const FrameShape& shape) {
    const size_t pixels = size_t(shape.widthPx) * shape.heightPx;
    float* to = reinterpret_cast<float*>(backend_->mapped(slot.scene).data());
    for (size_t v = 0; v < shape.views; ++v, to += pixels) {
        const std::span<const float> from = call.wants.sceneDepthM[shape.eye + v];
        if (from.empty())
            std::fill_n(to, pixels, INFINITY);
        else
            std::transform(from.begin(), from.begin() + ptrdiff_t(pixels), to, farthestSeenM);
    }
}

Result<std::span<const PixelView>> GpuRenderer::read(RenderAvatarId id) {
    if (!store_.find(id)) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", id);
    const LastDraw& last = lastDraws_.at(id);
    const SceneSet* set = last.encoded ? nullptr : cache_.find(last.set);
    if (!set) return fail(Code::InvalidArgument, "nothing was drawn of avatar {}", id);
    SubmittedFrame frames[gpu::kMaxViews];
    for (size_t k = 0; k < last.frameCount; ++k) {
        frames[k] = set->submitted(last.numbers[k]);
        if (!frames[k]) return fail(Code::Internal, "frame {} of avatar {} is gone", last.numbers[k], id);
    }
    return reader_.read({frames, last.frameCount});
}

FrameTiming GpuRenderer::timing(RenderAvatarId id) {
    const auto found = lastDraws_.find(id);
    const SceneSet* set = found == lastDraws_.end() ? nullptr : cache_.find(found->second.set);
    if (!set) return {};
    FrameTiming timing = reader_.timing(*set);
    timing.last = found->second.splats;
    return timing;
}

Result<FrameStats> GpuRenderer::stats(RenderAvatarId id) {
    const LoadedSubject* subject = store_.find(id);
    if (!subject) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", id);
    const LastDraw& last = lastDraws_.at(id);
    FrameStats stats;
    stats.residentBytes = backend_->residentBytes();
    stats.waits = waits_;
    stats.avatarBytes = subject->residentBytes;
    stats.splatBytes = subject->splatBytes;
    stats.keptBytes = subject->records->bytes();
    stats.detailShare = last.drawnShare;
    if (const SceneSet* set = cache_.find(last.set)) reader_.addStats(*set, last.splats.drawn, stats);
    return stats;
}

}  // namespace dpl
