// SPDX-License-Identifier: Apache-2.0
#include "sdk/splat/software_renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/sh.h"
#include "sdk/splat/mesh_depth.h"
#include "sdk/splat/splat_engine.h"
#include "sdk/visibility/components.h"
#include "sdk/visibility/detail.h"

namespace dpl {
namespace {

/** What makes drawing safe: lengths and indices. The file reader checks far more; avatars built in memory come here unchecked. */
Status checkMesh(const AvatarData& avatar) {
    const MeshData& mesh = avatar.mesh;
    const size_t vertices = mesh.restPositions.size(), triangles = mesh.triangles.size();
    DPL_CHECK_OK(checkRig(avatar.joints));
    if (avatar.joints.empty()) return fail(Code::CorruptData, "avatar '{}' has no joints", avatar.name);
    if (mesh.jointIndices.size() != vertices || mesh.jointWeights.size() != vertices)
        return fail(Code::CorruptData, "avatar '{}' has {} vertices and skin weights for {}", avatar.name, vertices,
                    mesh.jointWeights.size());
    for (size_t v = 0; v < vertices; ++v)
        for (int i = 0; i < 4; ++i)
            if (mesh.jointWeights[v][i] != 0 && mesh.jointIndices[v][i] >= avatar.joints.size())
                return fail(Code::CorruptData, "vertex {} hangs on joint {}; the rig has {}", v, mesh.jointIndices[v][i],
                            avatar.joints.size());
    for (size_t t = 0; t < triangles; ++t)
        for (int i = 0; i < 3; ++i)
            if (mesh.triangles[t][i] >= vertices)
                return fail(Code::CorruptData, "triangle {} uses vertex {} of {}", t, mesh.triangles[t][i], vertices);
    return checkCorrectives(avatar.correctives, avatar.joints.size(), vertices);
}

Status checkSplats(const AvatarData& avatar) {
    const SplatData& splats = avatar.splats;
    const size_t triangles = avatar.mesh.triangles.size(), count = splats.uv.size();
    if (splats.shDegree > kMaxShDegree) return fail(Code::CorruptData, "SH degree {}; at most {} is drawn", splats.shDegree, kMaxShDegree);
    const size_t shFloats = count * shCoefficientCount(splats.shDegree) * 3;
    if (splats.phi.size() != count || splats.scaleM.size() != count || splats.opacity.size() != count || splats.flags.size() != count ||
        splats.sh.size() != shFloats)
        return fail(Code::CorruptData, "the splat arrays of avatar '{}' have different lengths", avatar.name);
    if (splats.triangleStart.size() != triangles + 1 || splats.triangleStart.front() != 0 || splats.triangleStart.back() != count ||
        !std::is_sorted(splats.triangleStart.begin(), splats.triangleStart.end()))
        return fail(Code::CorruptData, "the splats of avatar '{}' do not cover its {} triangles in order", avatar.name, triangles);
    return {};
}

struct Drawable {
    PackedSplats general;  // one of the two
    CodedSplats splats;
    float kappaPx2 = 0, trainedPixelM = 0, detailShare = 0;
    bool compensated = false;
    GeneralDetailSubject generalSubject;
    GeneralDetail generalDetail;  // of the last frame, as is its share of the splats
    // Of avatars only.
    std::shared_ptr<const AvatarData> avatar;
    Components components;
    DetailSubject detailSubject;
    SplatDetail detail;  // of the last frame
    // The last pose and what follows from it.
    Pose pose;
    bool posed = false;     // the joints ...
    bool surfaced = false;  // ... and the surface, which waits until somebody sees it
    bool seen = true;       // in the last frame; general splats always
    uint32_t componentsInView = 0;
    PosedMesh mesh;
    std::vector<RenderedView> pictures;
    std::vector<PixelView> pixels;
    FrameStats stats;  // of the last frame; the bytes are counted when asked

    uint64_t bytes() const {
        uint64_t pictureBytes = 0;
        for (const RenderedView& p : pictures)
            pictureBytes += p.rgba.capacity() + (p.depthM.capacity() + p.meshDepthM.capacity()) * sizeof(float);
        return pictureBytes + general.bytes() + splats.bytes() + (avatar ? posingBytes(*avatar) : 0) + mesh.frames().size_bytes() +
               mesh.positions().size_bytes() + mesh.rest().size_bytes() + mesh.light().size_bytes() + mesh.worldFromRest().size_bytes() +
               mesh.coefficients().size_bytes() + mesh.nodes().size_bytes();
    }
};

bool samePose(const Pose& a, const Pose& b) {
    return a.localRotations.size() == b.localRotations.size() && a.rootTranslation == b.rootTranslation &&
           std::equal(a.localRotations.begin(), a.localRotations.end(), b.localRotations.begin());
}

class SoftwareRenderer final : public Renderer {
public:
    explicit SoftwareRenderer(uint32_t threadCount) : jobs_(threadCount), engine_(jobs_) {}

    std::string name() const override {
        return formatText("software ({} {})", jobs_.threadCount(), jobs_.threadCount() == 1 ? "thread" : "threads");
    }

    Result<RenderAvatarId> addAvatar(std::shared_ptr<const AvatarData> avatar) override {
        if (!avatar) return fail(Code::InvalidArgument, "no avatar");
        DPL_CHECK_OK(checkMesh(*avatar));
        DPL_CHECK_OK(checkSplats(*avatar));
        DPL_TRY(CodedSplats coded, codeSplats(avatar->mesh, avatar->splats));
        return addCodedAvatar(std::move(avatar), std::move(coded));
    }

    Result<RenderAvatarId> addCodedAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) override {
        if (!avatar) return fail(Code::InvalidArgument, "no avatar");
        DPL_CHECK_OK(checkMesh(*avatar));
        auto drawable = std::make_unique<Drawable>();
        drawable->splats = std::move(splats);
        measureDetail(*avatar, drawable->splats);
        drawable->detailSubject = DetailSubject(*avatar, drawable->splats);
        drawable->components =
            Components(*avatar, componentsOf(*avatar), reachOfTriangles(drawable->splats, avatar->mesh.triangles.size()));
        drawable->kappaPx2 = avatar->kappaPx2, drawable->compensated = avatar->compensated, drawable->trainedPixelM = avatar->trainedPixelM;
        drawable->avatar = std::move(avatar);
        return keep(std::move(drawable));
    }

    Result<RenderAvatarId> addSplats(const StaticSplatData& splats) override {
        auto drawable = std::make_unique<Drawable>();
        const std::vector<uint32_t> order =
            spatialOrder(splats.position);  // files keep the order of training, level of detail thins out neighbours
        drawable->general = PackedSplats(splats, order);
        if (drawable->general.count() != splats.count())
            return fail(Code::InvalidArgument, "the arrays of {} splats differ in length", splats.count());
        drawable->generalSubject = GeneralDetailSubject(measureGroups(splats, order), splats.count());
        drawable->kappaPx2 = splats.kappaPx2, drawable->compensated = splats.compensated;
        return keep(std::move(drawable));
    }

    void removeAvatar(RenderAvatarId avatar) override {
        together_.clear();
        drawables_.erase(avatar);
    }

    Status drawTogether(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) override {
        DPL_CHECK_OK(checkDrawn(what));
        DPL_CHECK_OK(checkScene(wants, views));
        together_.clear();
        bool mesh = false;
        uint32_t samples = 1;
        for (const Drawn& one : what) {
            const auto found = drawables_.find(one.avatar);
            if (found == drawables_.end()) return fail(Code::InvalidArgument, "there is no avatar {} in this renderer", one.avatar);
            Drawable& d = *found->second;
            together_.push_back(&d);
            if (!d.avatar) continue;
            DPL_CHECK_OK(setPose(d, *one.pose));
            mesh = true;
            samples = std::max(samples, coverageSamples(d.trainedPixelM, rootPosition(d.avatar->joints, d.pose), views));
        }
        if (wants.meshDepth && !mesh) return fail(Code::InvalidArgument, "general splats have no mesh and no depth of one");
        setDetails(views);
        leaveOutUnseen(views);
        Drawable& first = *together_[0];
        if (first.pictures.size() < views.size()) first.pictures.resize(views.size());
        first.pixels.resize(views.size());
        FrameStats& stats = first.stats;
        stats.views = uint32_t(views.size()), stats.splatsDrawn = 0, stats.bytesDecided = 0, stats.bytesDecoded = 0;
        stats.splatsAllowed = allowed_, stats.components = stats.componentsInView = 0;
        for (const Drawable* d : together_) stats.components += d->components.count(), stats.componentsInView += d->componentsInView;
        for (size_t v = 0; v < views.size(); ++v) {
            RenderedView& picture = first.pictures[v];
            bool started = false;
            for (const Drawable* d : together_)
                if (d->seen) project(*d, views[v], samples, started), started = true;
            if (!started) engine_.project(PackedSplats(), {}, views[v], 0, false, samples);
            stats.bytesDecided += engine_.decidedBytes(), stats.bytesDecoded += engine_.decodedBytes();
            engine_.bin();
            const std::span<const float> scene = v < std::size(wants.sceneDepthM) ? wants.sceneDepthM[v] : std::span<const float>();
            engine_.blendRgba8(picture.rgba, wants.depth ? &picture.depthM : nullptr, scene);
            first.pixels[v] = {views[v].widthPx, views[v].heightPx, picture.rgba, {}, {}};
            if (wants.depth) first.pixels[v].depthM = picture.depthM;
            if (wants.meshDepth) first.pixels[v].meshDepthM = drawMeshes(views[v], picture.meshDepthM);
            stats.splatsDrawn = std::max(stats.splatsDrawn, engine_.visibleCount());
        }
        return {};
    }

    Result<std::span<const PixelView>> read(RenderAvatarId avatar) override {
        const auto found = drawables_.find(avatar);
        if (found == drawables_.end()) return fail(Code::InvalidArgument, "there is no avatar {} in this renderer", avatar);
        if (found->second->pixels.empty()) return fail(Code::InvalidArgument, "nothing was drawn of avatar {}", avatar);
        return std::span<const PixelView>(found->second->pixels);
    }

    Result<FrameStats> stats(RenderAvatarId avatar) override {
        const auto found = drawables_.find(avatar);
        if (found == drawables_.end()) return fail(Code::InvalidArgument, "there is no avatar {} in this renderer", avatar);
        FrameStats stats = found->second->stats;
        const Drawable& shown = *found->second;
        stats.detailShare = shown.detailShare;
        stats.splatBytes = shown.general.bytes() + shown.splats.bytes();
        stats.avatarBytes = stats.splatBytes + (shown.avatar ? posingBytes(*shown.avatar) : 0);
        stats.residentBytes = engine_.bufferBytes() + meshDepth_.bytes() + anotherDepthM_.capacity() * sizeof(float);
        for (const auto& [id, drawable] : drawables_) stats.residentBytes += drawable->bytes();
        return stats;
    }

private:
    Status setPose(Drawable& d, const Pose& pose) {
        if (d.posed && samePose(d.pose, pose)) return {};
        DPL_CHECK_OK(checkPose(d.avatar->joints, pose));
        d.posed = d.surfaced = false;
        d.pose.localRotations = pose.localRotations;
        d.pose.rootTranslation = pose.rootTranslation;
        d.mesh.control(posedSubject(d), pose);
        d.posed = true;
        return {};
    }

    static PosedSubject posedSubject(const Drawable& d) { return {d.avatar->joints, d.avatar->mesh, d.avatar->correctives, {}}; }

    /** Poses the surface of those of together_ that some view may show. */
    void leaveOutUnseen(std::span<const Cameraf> views) {
        for (Drawable* d : together_) {
            if (!d->avatar) continue;
            const uint32_t unseen = d->components.unseen(d->mesh.worldFromRest(), d->mesh.coefficients(), views, d->kappaPx2,
                                                         d->detailSubject.largestGrowth(d->detail.perM2));
            d->componentsInView = d->components.count() - uint32_t(std::popcount(unseen));
            d->seen = d->componentsInView > 0 || d->components.count() == 0;
            if (d->seen && !d->surfaced) d->mesh.surface(posedSubject(*d), jobs_), d->surfaced = true;
        }
    }

    void project(const Drawable& d, const Cameraf& view, uint32_t samples, bool behind) {
        const auto put = [&](const auto& splats, const auto&... detail) {
            if (behind)
                engine_.add(splats, d.mesh.frames(), view, d.kappaPx2, d.compensated, samples, detail...);
            else
                engine_.project(splats, d.mesh.frames(), view, d.kappaPx2, d.compensated, samples, detail...);
        };
        if (d.avatar)
            put(d.splats, d.detail);
        else
            put(d.general, d.generalDetail, d.generalSubject.groups());
    }

    /** How much of each of together_ is drawn. */
    void setDetails(std::span<const Cameraf> views) {
        DetailMember members[kMaxDrawnTogether];
        for (size_t k = 0; k < together_.size(); ++k) {
            if (Drawable& d = *together_[k]; d.avatar)
                members[k].avatar = &d.detailSubject, members[k].worldFromRest = d.mesh.worldFromRest();
            else
                members[k].general = &d.generalSubject;
        }
        allowed_ = chooseDetails(detail_, views, {members, together_.size()});
        for (size_t k = 0; k < together_.size(); ++k)
            together_[k]->detail = members[k].detail, together_[k]->generalDetail = members[k].generalDetail,
            together_[k]->detailShare = members[k].share;
    }

    /** The nearest of the meshes that are drawn together. */
    std::span<const float> drawMeshes(const Cameraf& view, std::vector<float>& depthM) {
        bool first = true;
        for (const Drawable* d : together_) {
            if (!d->avatar || !d->seen) continue;
            meshDepth_.draw(jobs_, d->mesh.positions(), d->avatar->mesh.triangles, view, first ? depthM : anotherDepthM_);
            for (size_t i = 0; i < depthM.size() && !first; ++i)
                if (const float z = anotherDepthM_[i]; z > 0 && (depthM[i] == 0 || z < depthM[i])) depthM[i] = z;
            first = false;
        }
        if (first) depthM.assign(size_t(view.widthPx) * view.heightPx, 0);
        return depthM;
    }

    RenderAvatarId keep(std::unique_ptr<Drawable> drawable) {
        drawables_.emplace(nextId_, std::move(drawable));
        return nextId_++;
    }

    Jobs jobs_;
    SplatEngine engine_;
    MeshDepth meshDepth_;
    std::vector<float> anotherDepthM_;
    uint64_t allowed_ = 0;
    std::vector<Drawable*> together_;  // of the last draw
    std::map<RenderAvatarId, std::unique_ptr<Drawable>> drawables_;
    RenderAvatarId nextId_ = 1;
};

}  // namespace

std::unique_ptr<Renderer> createSoftwareRenderer(uint32_t threadCount) {
    return std::make_unique<SoftwareRenderer>(threadCount);
}

}  // namespace dpl
