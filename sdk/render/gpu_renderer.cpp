// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/gpu_renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/coverage.h"
#include "sdk/math/scene_depth.h"

namespace dpl {
namespace {

static_assert(kMaxDrawnTogether == gpu::kMaxDrawn);

constexpr float kSharedOrderRad = 0.035f;  // two views whose axes are further apart than 2 degrees are sorted each for itself (ADR 0002)
constexpr size_t kRowsKept = 4;            // of avatars that are drawn together; a room keeps one until somebody comes or goes

Status checkViews(std::span<const Cameraf> views) {
    if (views.empty() || views.size() > gpu::kMaxViews)
        return fail(Code::InvalidArgument, "{} views; 1 to {} are drawn at once", views.size(), gpu::kMaxViews);
    for (const Cameraf& c : views) {
        if (c.widthPx != views[0].widthPx || c.heightPx != views[0].heightPx)
            return fail(Code::InvalidArgument, "the views have different sizes");
        if (c.widthPx == 0 || c.heightPx == 0) return fail(Code::InvalidArgument, "a view of {} x {} px", c.widthPx, c.heightPx);
        float sum = c.fx + c.fy + c.cx + c.cy + c.viewFromWorldTranslation.x + c.viewFromWorldTranslation.y + c.viewFromWorldTranslation.z;
        for (int k = 0; k < 3; ++k) sum += c.viewFromWorldRotation[k].x + c.viewFromWorldRotation[k].y + c.viewFromWorldRotation[k].z;
        if (!std::isfinite(sum) || !(c.fx > 0) || !(c.fy > 0))
            return fail(Code::InvalidArgument, "a camera has a non-finite number or no focal length");
    }
    return {};
}

/** Whether one order of depth, along the mean axis, serves all views. It is exact for parallel axes. */
bool shareOrder(std::span<const Cameraf> views) {
    const auto forward = [](const Cameraf& c) { return glm::transpose(c.viewFromWorldRotation) * Vec3f(0, 0, 1); };
    const Vec3f first = forward(views.front()), last = forward(views.back());
    return std::atan2(glm::length(glm::cross(first, last)), glm::dot(first, last)) <= kSharedOrderRad;
}

}  // namespace

GpuRenderer::GpuRenderer(std::unique_ptr<Backend> backend, std::string name, const GpuOptions& options)
    : backend_(std::move(backend)), name_(std::move(name)), options_(options) {}

GpuRenderer::~GpuRenderer() {
    for (auto& [number, row] : rows_) freeRow(row);
    for (auto& [id, avatar] : avatars_) freeBuffers(avatar.owned);
}

Result<BufferId> GpuRenderer::makeBuffer(std::vector<BufferId>& owned, std::string label, uint64_t bytes, BufferMemory memory) {
    DPL_TRY(BufferId id, backend_->createBuffer({std::move(label), std::max<uint64_t>(bytes, 16), memory}));
    owned.push_back(id);
    return id;
}

template <class T>
Result<BufferId> GpuRenderer::uploadBuffer(std::vector<BufferId>& owned, std::string label, std::span<const T> items) {
    DPL_TRY(BufferId id, makeBuffer(owned, std::move(label), items.size_bytes()));
    if (!items.empty()) {
        DPL_CHECK_OK(backend_->write(id, 0, std::as_bytes(items)));
    }
    return id;
}

Result<RenderAvatarId> GpuRenderer::addAvatar(std::shared_ptr<const AvatarData> data) {
    if (!data) return fail(Code::InvalidArgument, "no avatar");
    DPL_CHECK_OK(checkSplatArrays(*data));
    DPL_TRY(CodedSplats coded, codeSplats(data->mesh, data->splats));
    return addCodedAvatar(std::move(data), std::move(coded));
}

Result<RenderAvatarId> GpuRenderer::addCodedAvatar(std::shared_ptr<const AvatarData> data, CodedSplats splats) {
    if (!data) return fail(Code::InvalidArgument, "no avatar");
    DPL_CHECK_OK(checkAvatar(*data, splats, backend_->info()));
    measureDetail(*data, splats);
    LoadedAvatar avatar;
    avatar.detailSubject = DetailSubject(*data, splats);
    avatar.data = std::move(data);
    const Status loaded = loadAvatar(avatar, splats);
    return keep(std::move(avatar), loaded);
}

Result<RenderAvatarId> GpuRenderer::addSplats(const StaticSplatData& splats) {
    DPL_CHECK_OK(checkSplats(splats, backend_->info()));
    LoadedAvatar loadedSplats;
    const Status loaded = loadSplats(loadedSplats, splats);
    return keep(std::move(loadedSplats), loaded);
}

Result<RenderAvatarId> GpuRenderer::keep(LoadedAvatar avatar, const Status& loaded) {
    Status made = loaded;
    const RenderAvatarId id = ++lastId_;
    Row row;
    row.members = {id}, row.subjects = {avatar.ids};
    if (made) made = makeWorkBuffers(row);
    if (!made) {
        freeRow(row);
        freeBuffers(avatar.owned);
        return made.error();
    }
    avatars_.emplace(id, std::move(avatar));
    row.number = id;
    rows_.emplace(id, std::move(row));
    return id;
}

Status GpuRenderer::loadSplats(LoadedAvatar& a, const StaticSplatData& splats) {
    a.splats = splatSetOf(splats);
    SubjectIds& ids = a.ids;
    ids.general = true;
    ids.wide = reachFar(splats);
    ids.splatCount = splats.count();
    ids.shDegree = splats.shDegree;
    ids.groupCount = (ids.splatCount + gpu::kSplatGroup - 1) / gpu::kSplatGroup;
    const std::vector<uint32_t> order =
        spatialOrder(splats.position);  // files keep the order of training: every fetch a cache line of its own
    a.generalSubject = GeneralDetailSubject(measureGroups(splats, order), splats.count());
    const std::vector<gpu::vec4> records = packSplats(splats, order, a.generalSubject.groups());
    const std::vector<gpu::uvec4> sh = packSh(splats, order);
    a.avatarBytes = a.splatBytes = records.size() * sizeof(gpu::vec4) + sh.size() * sizeof(gpu::uvec4);
    DPL_TRY(ids.splats, uploadBuffer<gpu::vec4>(a.owned, "splats", records));
    DPL_TRY(ids.sh, uploadBuffer<gpu::uvec4>(a.owned, "sh", sh));
    return {};
}

Status GpuRenderer::loadAvatar(LoadedAvatar& a, const CodedSplats& splats) {
    const AvatarData& data = *a.data;
    a.splats = splatSetOf(data, splats);
    const AvatarRecords records = packAvatar(data, splats);
    if (options_.cull) a.components = records.components;
    SubjectIds& ids = a.ids;
    ids.componentCount = a.components.count();
    ids.vertexCount = uint32_t(data.mesh.restPositions.size());
    ids.jointCount = uint32_t(data.joints.size());
    ids.corrected = !data.correctives.empty();
    ids.triangleCount = uint32_t(records.triangles.size());
    ids.splatCount = splats.count();
    ids.shDegree = splats.shDegree;
    ids.groupCount = 2 * uint32_t(splats.chunks.size());
    for (const SplatChunk& c : splats.chunks) ids.filledGroups += (c.splatCount + gpu::kSplatGroup - 1) / gpu::kSplatGroup;
    ids.codes = records.where;
    a.splatBytes = splats.bytes();
    a.avatarBytes = splats.bytes() + posingBytes(data) + records.triangles.size() * sizeof(gpu::TriangleRecord) +
                    records.vertices.size() * sizeof(gpu::VertexRecord) +
                    records.correctedVertices.size() * sizeof(gpu::CorrectedVertexRecord);
    if (ids.corrected) {
        DPL_TRY(ids.vertices, uploadBuffer<gpu::CorrectedVertexRecord>(a.owned, "vertices", records.correctedVertices));
    } else {
        DPL_TRY(ids.vertices, uploadBuffer<gpu::VertexRecord>(a.owned, "vertices", records.vertices));
    }
    DPL_TRY(ids.triangles, uploadBuffer<gpu::TriangleRecord>(a.owned, "triangles", records.triangles));
    DPL_TRY(ids.splats, uploadBuffer<uint32_t>(a.owned, "splats", records.codes));
    DPL_TRY(ids.posed, makeBuffer(a.owned, "posed", ids.vertexCount * 16ull));
    DPL_TRY(ids.triangleFrames, makeBuffer(a.owned, "triangle frames", ids.triangleCount * uint64_t(sizeof(gpu::TriangleFrame))));
    return {};
}

void GpuRenderer::freeBuffers(const std::vector<BufferId>& buffers) {
    for (BufferId id : buffers) backend_->destroyBuffer(id);
}

void GpuRenderer::freeRow(Row& row) {
    for (ShapedFrame& f : row.frames) freeFrame(f);
    freeBuffers(row.owned);
}

void GpuRenderer::removeAvatar(RenderAvatarId id) {
    const auto it = avatars_.find(id);
    if (it == avatars_.end()) return;
    for (auto row = rows_.begin(); row != rows_.end();) {
        if (row->second.holds(id))
            freeRow(row->second), row = rows_.erase(row);
        else
            ++row;
    }
    freeBuffers(it->second.owned);
    avatars_.erase(it);
}

/** The row of these avatars; made when they are drawn together for the first time, and the one not used for longest goes. */
Result<GpuRenderer::Row*> GpuRenderer::rowOf(std::span<const Drawn> what) {
    DPL_CHECK_OK(checkRow(what));
    for (const Drawn& d : what)
        if (!avatars_.contains(d.avatar)) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", d.avatar);
    if (what.size() == 1) return &rows_.at(what[0].avatar);
    size_t together = 0;
    auto oldest = rows_.end();
    for (auto it = rows_.begin(); it != rows_.end(); ++it) {
        Row& row = it->second;
        if (std::equal(what.begin(), what.end(), row.members.begin(), row.members.end(),
                       [](const Drawn& d, RenderAvatarId member) { return d.avatar == member; }))
            return &row;
        if (row.members.size() == 1) continue;
        ++together;
        if (oldest == rows_.end() || row.lastUse < oldest->second.lastUse) oldest = it;
    }
    Row row;
    for (const Drawn& d : what) row.members.push_back(d.avatar), row.subjects.push_back(avatars_.at(d.avatar).ids);
    if (together >= kRowsKept) freeRow(oldest->second), rows_.erase(oldest);
    if (const Status made = makeWorkBuffers(row); !made) {
        freeRow(row);
        return made.error();
    }
    row.number = ++lastId_;
    return &rows_.emplace(row.number, std::move(row)).first->second;
}

Status GpuRenderer::drawTogether(std::span<const Drawn> what, std::span<const Cameraf> views, const FrameWants& wants) {
    DPL_CHECK_OK(checkViews(views));
    DPL_CHECK_OK(checkScene(wants, views));
    DPL_TRY(Row * row, rowOf(what));
    bool mesh = false;
    uint32_t samples = 1;
    float kappaPx2 = INFINITY;
    for (const Drawn& d : what) {
        const auto& data = avatars_.at(d.avatar).data;
        mesh |= data != nullptr;
        kappaPx2 = std::min(kappaPx2, avatars_.at(d.avatar).splats.kappaPx2);
        if (data && backend_->info().fourSamples)
            samples = std::max(samples, coverageSamples(data->trainedPixelM, rootPosition(data->joints, *d.pose), views));
    }
    if (wants.meshDepth && !mesh) return fail(Code::InvalidArgument, "general splats have no mesh and no depth of one");
    poseRow(*row, what, views);
    avatars_.at(what[0].avatar).lastRow = 0;
    std::fill(std::begin(row->drawn), std::end(row->drawn), 0);
    const Fill fill =
        kappaPx2 >= kTileMinKappaPx2 ? options_.fill : Fill::Quads;  // whatever the samples: they share κ, and their columns are shorter
    const Shape shape{
        views[0].widthPx, views[0].heightPx, uint32_t(views.size()), wants.depth, wants.meshDepth, wants.behindScene(), 0, samples, fill};
    Status drawn;
    if (views.size() == 1 || (options_.shareViews && shareOrder(views))) {
        drawn = drawFrame(*row, what, views, shape, {wants.sceneDepthM, views.size()});
    } else {
        for (Shape alone = shape; alone.eye < views.size() && drawn; ++alone.eye) {
            alone.views = 1;
            drawn = drawFrame(*row, what, views.subspan(alone.eye, 1), alone, {wants.sceneDepthM + alone.eye, 1});
        }
    }
    if (!drawn) return std::fill(std::begin(row->drawn), std::end(row->drawn), 0), drawn;  // half a pair is not shown
    avatars_.at(what[0].avatar).lastRow = row->number;
    return drawn;
}

/** Joints of each, and how much of it is drawn. */
void GpuRenderer::poseRow(Row& row, std::span<const Drawn> what, std::span<const Cameraf> views) {
    DetailMember members[kMaxDrawnTogether];
    for (size_t k = 0; k < what.size(); ++k) {
        LoadedAvatar& avatar = avatars_.at(what[k].avatar);
        if (!avatar.data) {
            members[k].general = &avatar.generalSubject;
            continue;
        }
        jointTransforms(avatar.data->joints, *what[k].pose, avatar.worldFromRest);
        members[k].avatar = &avatar.detailSubject, members[k].worldFromRest = avatar.worldFromRest;
    }
    row.splatsAllowed = chooseDetails(detail_, views, {members, what.size()});
    for (size_t k = 0; k < what.size(); ++k) {
        LoadedAvatar& avatar = avatars_.at(what[k].avatar);
        avatar.detail = members[k].detail, avatar.generalDetail = members[k].generalDetail, avatar.detailShare = members[k].share;
    }
}

Status GpuRenderer::drawFrame(Row& row, std::span<const Drawn> what, std::span<const Cameraf> views, const Shape& shape,
                              std::span<const std::span<const float>> sceneDepthM) {
    DPL_TRY(ShapedFrame * frame, frameOf(row, shape));
    Slot& slot = frame->slots[frame->next];
    if (!backend_->finished(slot.draw)) {
        ++waits_;
        DPL_CHECK_OK(backend_->wait(slot.draw));
    }
    fill(row, slot, what, views, shape);
    if (shape.sceneDepth) writeScene(slot, shape, sceneDepthM);
    DPL_CHECK_OK(backend_->submit(slot.draw));
    frame->next = (frame->next + 1) % kFramesInFlight;
    slot.number = frame->lastUse = row.lastUse = row.drawn[shape.eye] = ++frameNumber_;
    return {};
}

void GpuRenderer::fill(const Row& row, Slot& slot, std::span<const Drawn> what, std::span<const Cameraf> views, const Shape& shape) {
    slot.componentsInView = 0;
    for (size_t k = 0; k < row.members.size(); ++k) {
        const LoadedAvatar& avatar = avatars_.at(row.members[k]);
        const float growth = avatar.detailSubject.largestGrowth(avatar.detail.perM2);
        uint32_t unseen = 0;
        if (avatar.data) {
            writePalette(avatar, *what[k].pose, slot.palette[k]);
            if (!shape.meshDepth)
                unseen = avatar.components.unseen(avatar.worldFromRest, coefficients_, views, avatar.splats.kappaPx2,
                                                  growth);  // the depth of the mesh is drawn from every triangle
            slot.componentsInView += avatar.components.count() - uint32_t(std::popcount(unseen));
            if (unseen != 0 && unseen == avatar.components.all()) unseen = ~0u;
        }
        gpu::FrameData block = packFrame(avatar.splats, views, shape.samples, avatar.detail, growth, unseen);
        block.flags.z = options_.cull ? 0 : 1, block.flags.w = row.ids.splatCount;
        if (!avatar.data) packGeneralDetail(avatar.generalDetail, block);
        std::memcpy(backend_->mapped(slot.frame[k]).data(), &block, sizeof(block));
    }
}

void GpuRenderer::writeScene(const Slot& slot, const Shape& shape, std::span<const std::span<const float>> sceneDepthM) {
    const size_t pixels = size_t(shape.widthPx) * shape.heightPx;
    float* to = reinterpret_cast<float*>(backend_->mapped(slot.scene).data());
    for (size_t v = 0; v < shape.views; ++v, to += pixels) {
        const std::span<const float> from = sceneDepthM[v];
        if (from.empty())
            std::fill_n(to, pixels, INFINITY);
        else
            std::transform(from.begin(), from.begin() + ptrdiff_t(pixels), to, farthestSeenM);
    }
}

void GpuRenderer::writePalette(const LoadedAvatar& avatar, const Pose& pose, BufferId palette) {
    coefficients_.clear(), nodes_.clear();
    if (const PoseCorrectiveData& correctives = avatar.data->correctives; !correctives.empty()) {
        correctiveCoefficients(correctives, pose, coefficients_);
        correctiveNodes(correctives, coefficients_, nodes_);
    }
    packPalette(avatar.worldFromRest, nodes_, {reinterpret_cast<gpu::vec4*>(backend_->mapped(palette).data()), paletteRows(*avatar.data)});
}

}  // namespace dpl
