// SPDX-License-Identifier: Apache-2.0
#include "sdk/splat/software_renderer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <map>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/core/task.h"
#include "sdk/draw/check_draw.h"
#include "sdk/draw/check_subject.h"
#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/coverage.h"
#include "sdk/splat/mesh_depth.h"
#include "sdk/splat/splat_engine.h"
#include "sdk/visibility/components.h"
#include "sdk/visibility/detail.h"

namespace dpl {
namespace {

/** A loaded subject, an avatar or general splats, and the results of its last draw. */
struct Drawable final : PreparedSubject {
    const Renderer* owner = nullptr;
    float kappaPx2 = 0;  // low-pass of a pixel
    bool compensated = false;
    float detailShare = 0;  // of the last draw
    bool seen = true;       // by some view of the last draw; always true for general splats
    std::vector<RenderedView> pictures;
    std::vector<PixelView> pixels;
    FrameStats stats;    // of the last draw, without bytes, which stats() adds
    FrameTiming timing;  // of the last draw that belongs to the subject

    // General splats.
    PackedSplats general;
    GeneralDetailSubject generalSubject;
    GeneralDetail generalDetail;  // of the last draw

    // An avatar; null: general splats.
    std::shared_ptr<const AvatarData> avatar;
    std::vector<Vec3f> normals;  // at rest; empty without light
    ClothLimits cloth;
    CodedSplats splats;
    float trainedPixelM = 0;
    Components components;
    uint32_t componentsInView = 0;
    DetailSubject detailSubject;
    SplatDetail detail;  // of the last draw
    Pose pose;           // of the last draw
    uint64_t hiddenLayers = 0;
    std::vector<Triangle> shownTriangles;  // those of layers that are not hidden, where some are
    PosedMesh mesh;
    bool posed = false;     // the joints of `mesh` follow `pose`
    bool surfaced = false;  // the surface of `mesh` follows `pose`; it is posed when a view first sees it

    uint64_t bytes() const override {
        uint64_t pictureBytes = 0;
        for (const RenderedView& p : pictures)
            pictureBytes += p.rgba.capacity() + (p.depthM.capacity() + p.meshDepthM.capacity()) * sizeof(float);
        return pictureBytes + general.bytes() + splats.bytes() + (avatar ? posingBytes(*avatar) : 0) + normals.size() * sizeof(Vec3f) +
               cloth.bytes() + mesh.frames().size_bytes() + mesh.positions().size_bytes() + mesh.rest().size_bytes() +
               mesh.light().size_bytes() + mesh.sceneLight().size_bytes() + mesh.worldFromRest().size_bytes() +
               mesh.coefficients().size_bytes() + mesh.nodes().size_bytes();
    }
};

class SoftwareRenderer final : public Renderer {
public:
    explicit SoftwareRenderer(uint32_t threadCount) : jobs_(threadCount), engine_(jobs_) {}

    std::string name() const override {
        return formatText("software ({} {})", jobs_.threadCount(), jobs_.threadCount() == 1 ? "thread" : "threads");
    }

    Result<std::unique_ptr<PreparedSubject>> prepareAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) const override {
        if (!avatar) return fail(Code::InvalidArgument, "no avatar");
        DPL_RETURN_IF_ERROR(checkAvatarPosable(*avatar));
        auto drawable = std::make_unique<Drawable>();
        drawable->owner = this;
        drawable->splats = std::move(splats);
        DPL_RETURN_IF_ERROR(taskAt(0.1));
        measureDetail(*avatar, drawable->splats);
        drawable->detailSubject = DetailSubject(*avatar, drawable->splats);
        drawable->components =
            Components(*avatar, componentsOf(*avatar), reachOfTriangles(drawable->splats, avatar->mesh.triangles.size()));
        drawable->kappaPx2 = avatar->kappaPx2, drawable->compensated = avatar->compensated, drawable->trainedPixelM = avatar->trainedPixelM;
        if (!avatar->light.empty()) drawable->normals = restVertexNormals(avatar->mesh);
        drawable->cloth = ClothLimits(avatar->joints, avatar->mesh, avatar->correctives);
        drawable->avatar = std::move(avatar);
        return std::unique_ptr<PreparedSubject>(std::move(drawable));
    }

    Result<std::unique_ptr<PreparedSubject>> prepareSplats(const StaticSplatData& splats) const override {
        DPL_RETURN_IF_ERROR(checkGeneralSplats(splats));
        auto drawable = std::make_unique<Drawable>();
        drawable->owner = this;
        // Level of detail thins out groups of neighbours. Files keep the order of training, so the splats are sorted by position here.
        const std::vector<uint32_t> order = spatialOrder(splats.position);
        DPL_RETURN_IF_ERROR(taskAt(0.4));
        drawable->general = PackedSplats(splats, order);
        DPL_RETURN_IF_ERROR(taskAt(0.7));
        drawable->generalSubject = GeneralDetailSubject(measureGroups(splats, order), splats.count());
        drawable->kappaPx2 = splats.kappaPx2, drawable->compensated = splats.compensated;
        return std::unique_ptr<PreparedSubject>(std::move(drawable));
    }

    Result<RenderAvatarId> begin(std::unique_ptr<PreparedSubject> subject) override {
        const auto* drawable = dynamic_cast<const Drawable*>(subject.get());
        if (!drawable || drawable->owner != this) return fail(Code::InvalidArgument, "the subject was prepared by another renderer");
        drawables_.emplace(nextId_, std::unique_ptr<Drawable>(static_cast<Drawable*>(subject.release())));
        return nextId_++;
    }

    void removeAvatar(RenderAvatarId avatar) override {
        together_.clear();
        drawables_.erase(avatar);
    }

    Status drawTogether(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) override {
        const auto start = std::chrono::steady_clock::now();
        DPL_TRY(const uint32_t samples, startFrame(what, views, wants));
        Drawable& first = *together_[0];
        if (first.pictures.size() < views.size()) first.pictures.resize(views.size());
        first.pixels.resize(views.size());
        for (size_t v = 0; v < views.size(); ++v) {
            RenderedView& picture = first.pictures[v];
            projectView(v, views[v], samples);
            engine_.bin();
            engine_.blendRgba8(picture.rgba, wants.depth ? &picture.depthM : nullptr, wants.sceneDepthM[v]);
            first.pixels[v] = {views[v].widthPx, views[v].heightPx, picture.rgba, {}, {}};
            if (wants.depth) first.pixels[v].depthM = picture.depthM;
            if (wants.meshDepth) first.pixels[v].meshDepthM = drawMeshes(v, picture.meshDepthM);
            first.stats.splatsDrawn = std::max(first.stats.splatsDrawn, engine_.visibleCount());
        }
        endFrame(start);
        return {};
    }

    Result<ScreenSplats> projectTogether(std::span<const Drawn> what, std::span<const Cameraf> views, std::span<ScreenSplat> out) override {
        const auto start = std::chrono::steady_clock::now();
        DPL_TRY(const uint32_t samples, startFrame(what, views, FrameWants()));
        Drawable& first = *together_[0];
        first.pixels.clear();
        ScreenSplats made;
        made.samples = samples;
        size_t written = 0;
        for (size_t v = 0; v < views.size(); ++v) {
            projectView(v, views[v], samples);
            engine_.sort();
            const uint32_t count = made.counts[v] = engine_.visibleCount();
            if (count > out.size() - written)
                return fail(Code::InvalidArgument, "room for {} splats; view {} shows {} after {} of the views before it", out.size(), v,
                            count, written);
            engine_.writeSorted(out.subspan(written, count));
            written += count;
            first.stats.splatsDrawn = std::max(first.stats.splatsDrawn, count);
        }
        endFrame(start);
        return made;
    }

    Result<std::span<const PixelView>> read(RenderAvatarId avatar) override {
        const auto found = drawables_.find(avatar);
        if (found == drawables_.end()) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", avatar);
        if (found->second->pixels.empty()) return fail(Code::InvalidArgument, "nothing was drawn of avatar {}", avatar);
        return std::span<const PixelView>(found->second->pixels);
    }

    FrameTiming timing(RenderAvatarId avatar) override {
        const auto found = drawables_.find(avatar);
        return found == drawables_.end() ? FrameTiming() : found->second->timing;
    }

    const CodedSplats* splatsOf(RenderAvatarId avatar) const override {
        const auto found = drawables_.find(avatar);
        return found == drawables_.end() || !found->second->avatar ? nullptr : &found->second->splats;
    }

    Result<FrameStats> stats(RenderAvatarId avatar) override {
        const auto found = drawables_.find(avatar);
        if (found == drawables_.end()) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", avatar);
        FrameStats stats = found->second->stats;
        const Drawable& shown = *found->second;
        stats.detailShare = shown.detailShare;
        stats.splatBytes = shown.general.bytes() + shown.splats.bytes();
        stats.avatarBytes = stats.splatBytes + (shown.avatar ? posingBytes(*shown.avatar) : 0);
        stats.residentBytes = residentBytes();
        return stats;
    }

    uint64_t residentBytes() const override {
        uint64_t bytes = engine_.bufferBytes() + meshDepth_.bytes() + anotherDepthM_.capacity() * sizeof(float);
        for (const auto& [id, drawable] : drawables_) bytes += drawable->bytes();
        return bytes;
    }

private:
    /** What all views of a draw share: poses, level of detail, what is seen. Returns the samples a pixel. */
    Result<uint32_t> startFrame(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) {
        DPL_RETURN_IF_ERROR(checkDraw(what, views, wants, [this](RenderAvatarId id) { return jointsOf(id); }));
        together_.clear();
        uint32_t samples = 1;
        for (const Drawn& one : what) {
            Drawable& d = *drawables_.at(one.avatar);
            SubjectViews& seenBy = seenBy_[together_.size()];
            seenBy = SubjectViews(one.placement, views);
            together_.push_back(&d);
            if (!d.avatar) continue;
            setPose(d, *one.pose);
            hideLayers(d, one.hiddenLayers);
            samples = std::max(samples, coverageSamples(d.trainedPixelM, rootPosition(d.avatar->joints, d.pose), seenBy.cameras()));
        }
        setDetails();
        leaveOutUnseen();
        FrameStats& stats = together_[0]->stats;
        stats.views = uint32_t(views.size()), stats.splatsDrawn = 0, stats.bytesDecided = 0, stats.bytesDecoded = 0;
        stats.splatsAllowed = splats_.drawn, stats.components = stats.componentsInView = 0;
        for (const Drawable* d : together_) stats.components += d->components.count(), stats.componentsInView += d->componentsInView;
        return samples;
    }

    /** Projects all that is seen into view v. */
    void projectView(size_t v, const Cameraf& camera, uint32_t samples) {
        bool started = false;
        for (size_t k = 0; k < together_.size(); ++k)
            if (together_[k]->seen) project(*together_[k], seenBy_[k][v], samples, started), started = true;
        if (!started) engine_.project(PackedSplats(), {}, camera, 0, false, samples);
        FrameStats& stats = together_[0]->stats;
        stats.bytesDecided += engine_.decidedBytes(), stats.bytesDecoded += engine_.decodedBytes();
    }

    void endFrame(std::chrono::steady_clock::time_point start) {
        const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
        together_[0]->timing = {++frameNumber_, took.count(), splats_.drawn, splats_};
    }

    std::optional<std::span<const JointData>> jointsOf(RenderAvatarId id) const {
        const auto found = drawables_.find(id);
        if (found == drawables_.end()) return std::nullopt;
        const AvatarData* avatar = found->second->avatar.get();
        return avatar ? std::span<const JointData>(avatar->joints) : std::span<const JointData>();
    }

    static void setPose(Drawable& d, const Pose& pose) {
        if (d.posed && samePose(d.pose, pose)) return;
        d.posed = d.surfaced = false;
        d.pose = pose;
        d.mesh.control(posedSubject(d), pose);
        d.posed = true;
    }

    static void hideLayers(Drawable& d, uint64_t layers) {
        if (d.hiddenLayers == layers) return;
        d.hiddenLayers = layers, d.surfaced = false;
        d.shownTriangles.clear();
        const MeshData& mesh = d.avatar->mesh;
        for (size_t l = 0; l < mesh.layers.size() && layers != 0; ++l) {
            const auto first = mesh.triangles.begin() + std::ptrdiff_t(mesh.layers[l].firstTriangle);
            if (!isHidden(d, l))
                d.shownTriangles.insert(d.shownTriangles.end(), first, first + std::ptrdiff_t(mesh.layers[l].triangleCount));
        }
    }
    static bool isHidden(const Drawable& d, size_t layer) { return layer < 64 && (d.hiddenLayers >> layer & 1) != 0; }

    void poseSurface(Drawable& d) {
        d.mesh.surface(posedSubject(d), jobs_);
        const std::vector<LayerData>& layers = d.avatar->mesh.layers;
        for (size_t l = 0; l < layers.size(); ++l)
            if (isHidden(d, l)) d.mesh.hideTriangles(layers[l].firstTriangle, layers[l].triangleCount);
        d.surfaced = true;
    }

    static PosedSubject posedSubject(const Drawable& d) {
        return {d.avatar->joints, d.avatar->mesh, d.avatar->correctives, {}, &d.avatar->light, d.normals, &d.cloth, &d.avatar->expressions};
    }

    /** Poses the surface of each avatar of together_ that some view may show, and sets `seen` of all. */
    void leaveOutUnseen() {
        for (size_t k = 0; k < together_.size(); ++k) {
            Drawable* d = together_[k];
            if (!d->avatar) continue;
            const uint32_t unseen =
                d->components.unseen(d->mesh.worldFromRest(), d->mesh.coefficients(), seenBy_[k].cameras(), d->kappaPx2,
                                     d->detailSubject.largestGrowth(d->detail.perM2), seenBy_[k].scale(), d->mesh.pushedM()) |
                d->components.ofLayers(d->hiddenLayers);
            d->componentsInView = d->components.count() - uint32_t(std::popcount(unseen));
            d->seen = d->componentsInView > 0 || d->components.count() == 0;
            if (d->seen && !d->surfaced) poseSurface(*d);
        }
    }

    void project(const Drawable& d, const SubjectView& view, uint32_t samples, bool behind) {
        const auto put = [&](const auto& splats, const auto&... detail) {
            if (behind)
                engine_.add(splats, d.mesh.frames(), view, d.kappaPx2, d.compensated, samples, detail...);
            else
                engine_.project(splats, d.mesh.frames(), view, d.kappaPx2, d.compensated, samples, detail...);
        };
        if (d.avatar)
            put(d.splats, d.detail);
        else
            put(d.general, KeptGroups{d.generalDetail, d.generalSubject.groups()});
    }

    /** Chooses how many splats of each subject of together_ are drawn. */
    void setDetails() {
        DetailMember members[kMaxDrawnTogether];
        for (size_t k = 0; k < together_.size(); ++k) {
            if (Drawable& d = *together_[k]; d.avatar)
                members[k].avatar = &d.detailSubject, members[k].worldFromRest = d.mesh.worldFromRest();
            else
                members[k].general = &d.generalSubject;
            members[k].views = seenBy_[k].cameras(), members[k].scale = seenBy_[k].scale();
        }
        splats_ = chooseDetails(detail_, {members, together_.size()});
        for (size_t k = 0; k < together_.size(); ++k)
            together_[k]->detail = members[k].detail, together_[k]->generalDetail = members[k].generalDetail,
            together_[k]->detailShare = members[k].share;
    }

    /** Depth of the nearest mesh of together_ at every pixel of view v: view z, metres, 0 = none. */
    std::span<const float> drawMeshes(size_t v, std::vector<float>& depthM) {
        bool first = true;
        for (size_t k = 0; k < together_.size(); ++k) {
            const Drawable* d = together_[k];
            if (!d->avatar || !d->seen) continue;
            const std::vector<Triangle>& triangles = d->hiddenLayers != 0 ? d->shownTriangles : d->avatar->mesh.triangles;
            meshDepth_.draw(jobs_, d->mesh.positions(), triangles, seenBy_[k][v], first ? depthM : anotherDepthM_);
            for (size_t i = 0; i < depthM.size() && !first; ++i)
                if (const float z = anotherDepthM_[i]; z > 0 && (depthM[i] == 0 || z < depthM[i])) depthM[i] = z;
            first = false;
        }
        if (first) depthM.assign(size_t(seenBy_[0][v].camera.widthPx) * seenBy_[0][v].camera.heightPx, 0);
        return depthM;
    }

    Jobs jobs_;
    SplatEngine engine_;
    MeshDepth meshDepth_;
    std::vector<float> anotherDepthM_;  // scratch of drawMeshes
    DetailTotals splats_;               // of the last setDetails
    uint64_t frameNumber_ = 0;
    std::vector<Drawable*> together_;                     // subjects of the last draw
    std::array<SubjectViews, kMaxDrawnTogether> seenBy_;  // each of them
    std::map<RenderAvatarId, std::unique_ptr<Drawable>> drawables_;
    RenderAvatarId nextId_ = 1;
};

}  // namespace

std::unique_ptr<Renderer> createSoftwareRenderer(uint32_t threadCount) {
    return std::make_unique<SoftwareRenderer>(threadCount);
}

}  // namespace dpl
