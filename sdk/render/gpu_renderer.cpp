#include "sdk/render/gpu_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/core/log.h"
#include "sdk/format/splat_codec.h"
#include "sdk/math/coverage.h"
#include "sdk/math/half.h"
#include "sdk/math/scene_depth.h"
#include "sdk/render/passes/chunks.h"
#include "sdk/render/passes/compact.h"
#include "sdk/render/passes/draw.h"
#include "sdk/render/passes/mesh_depth.h"
#include "sdk/render/passes/project.h"
#include "sdk/render/passes/skin.h"
#include "sdk/render/passes/sort.h"
#include "sdk/render/passes/tiles.h"
#include "sdk/render/passes/triangles.h"

namespace dpl {
namespace {

static_assert(kMaxDrawnTogether == gpu::kMaxDrawn);

constexpr float kSharedOrderRad = 0.035f;  // two views whose axes are further apart than 2 degrees are sorted each for itself (ADR 0002)
constexpr std::array<std::byte, 4> kZero{};
constexpr size_t kRowsKept = 4;    // of avatars that are drawn together; a room keeps one until somebody comes or goes
constexpr size_t kFramesKept = 4;  // recorded frame shapes an avatar keeps; an app uses one or two at two sample counts, a resize leaves others behind

Status checkViews(std::span<const Cameraf> views) {
    if (views.empty() || views.size() > gpu::kMaxViews) return fail(Code::InvalidArgument, "{} views; 1 to {} are drawn at once", views.size(), gpu::kMaxViews);
    for (const Cameraf& c : views) {
        if (c.widthPx != views[0].widthPx || c.heightPx != views[0].heightPx) return fail(Code::InvalidArgument, "the views have different sizes");
        if (c.widthPx == 0 || c.heightPx == 0) return fail(Code::InvalidArgument, "a view of {} x {} px", c.widthPx, c.heightPx);
        float sum = c.fx + c.fy + c.cx + c.cy + c.viewFromWorldTranslation.x + c.viewFromWorldTranslation.y + c.viewFromWorldTranslation.z;
        for (int k = 0; k < 3; ++k) sum += c.viewFromWorldRotation[k].x + c.viewFromWorldRotation[k].y + c.viewFromWorldRotation[k].z;
        if (!std::isfinite(sum) || !(c.fx > 0) || !(c.fy > 0)) return fail(Code::InvalidArgument, "a camera has a non-finite number or no focal length");
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
    if (!items.empty()) { DPL_CHECK_OK(backend_->write(id, 0, std::as_bytes(items))); }
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
    LoadedAvatar avatar;
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
    ids.groupCount = ids.filledGroups = (ids.splatCount + gpu::kSplatGroup - 1) / gpu::kSplatGroup;
    const std::vector<gpu::GeneralSplatRecord> records = packSplats(splats);
    const std::vector<gpu::uvec4> sh = packSh(splats);
    a.avatarBytes = a.splatBytes = records.size() * sizeof(gpu::GeneralSplatRecord) + sh.size() * sizeof(gpu::uvec4);
    DPL_TRY(ids.splats, uploadBuffer<gpu::GeneralSplatRecord>(a.owned, "splats", records));
    DPL_TRY(ids.sh, uploadBuffer<gpu::uvec4>(a.owned, "sh", sh));
    return {};
}

Status GpuRenderer::loadAvatar(LoadedAvatar& a, const CodedSplats& splats) {
    const AvatarData& data = *a.data;
    a.splats = splatSetOf(data, splats);
    const AvatarRecords records = packAvatar(data, splats);
    SubjectIds& ids = a.ids;
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
    a.avatarBytes = splats.bytes() + posingBytes(data) + records.triangles.size() * sizeof(gpu::TriangleRecord) + records.vertices.size() * sizeof(gpu::VertexRecord) +
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

/** Where each member's splats lie in the lists of a frame, and these lists, whatever its size. */
Status GpuRenderer::makeWorkBuffers(Row& row) {
    FrameIds& ids = row.ids;
    ids.layered = backend_->info().multiview;
    uint64_t splats = 0;
    for (SubjectIds& subject : row.subjects) {
        subject.drawn = uint32_t(ids.endGroups.size()), subject.firstGroup = ids.allGroups, subject.firstSplat = uint32_t(splats);
        splats += subject.splatCount;
        if (splats * sizeof(gpu::ProjectedSplat) * gpu::kMaxViews > backend_->info().maxBindingBytes)
            return fail(Code::Unsupported, "{} avatars together have more splats than {} draws at once ({}); draw fewer together", row.subjects.size(), backend_->info().name,
                        backend_->info().maxBindingBytes / (sizeof(gpu::ProjectedSplat) * gpu::kMaxViews));
        ids.allGroups += subject.groupCount;
        ids.endGroups.push_back(ids.allGroups);
        ids.filledGroups += subject.filledGroups;
        ids.general |= subject.general;
        ids.wide |= subject.wide;
        ids.vertexCount += subject.vertexCount;
    }
    ids.splatCount = uint32_t(splats);
    DPL_TRY(ids.visibility, makeBuffer(row.owned, "visibility", (ids.firstDepth() + splats) * 4));
    DPL_TRY(ids.counts, makeBuffer(row.owned, "counts", sizeof(gpu::FrameCounts)));
    DPL_TRY(ids.pairs, makeBuffer(row.owned, "pairs", splats * 8));
    DPL_TRY(ids.pairsSwap, makeBuffer(row.owned, "pairs swap", splats * 8));
    DPL_TRY(ids.histogram, makeBuffer(row.owned, "histogram", ids.histogramWords() * 4));
    DPL_CHECK_OK(backend_->write(ids.histogram, 0, kZero));  // each round clears its own part; this is for the check of reads
    return {};
}

Status GpuRenderer::build(const Row& row, ShapedFrame& f) {
    f.ids = row.ids;
    FrameIds& ids = f.ids;
    ids.viewCount = f.shape.views;
    ids.widthPx = f.shape.widthPx;
    ids.heightPx = f.shape.heightPx;
    ids.depth = f.shape.depth;
    ids.sceneDepth = f.shape.sceneDepth;
    ids.halfColour = options_.preciseBlending;
    ids.cull = options_.cullTriangles;
    ids.floatKeys = !options_.quantiseDepth;
    ids.shuffle = backend_->info().shuffle;
    ids.samples = f.shape.samples;
    DPL_TRY(ids.target, backend_->createTarget({ids.widthPx, ids.heightPx, ids.viewCount, ids.depth, ids.layered, ids.halfColour, ids.samples}));
    // Whoever walks away from this avatar should not wait for a shader compiler: its other pipeline is made now, its other target when it is needed.
    const bool trained = std::any_of(row.members.begin(), row.members.end(), [&](RenderAvatarId id) { const LoadedAvatar& a = avatars_.at(id); return a.data && a.data->trainedPixelM > 0; });
    if (trained && backend_->info().fourSamples) { DPL_CHECK_OK(backend_->drawPipeline(drawPipelineOf(ids, ids.samples == 1 ? kCoverageSamples : 1))); }
    DPL_TRY(ids.projected, makeBuffer(f.owned, "projected", uint64_t(ids.splatCount) * ids.viewCount * sizeof(gpu::ProjectedSplat)));
    if (f.shape.meshDepth) {
        DPL_TRY(ids.meshDepth, makeBuffer(f.owned, "mesh depth", uint64_t(ids.widthPx) * ids.heightPx * ids.viewCount * 4));
        DPL_CHECK_OK(backend_->write(ids.meshDepth, 0, kZero));  // every frame fills it; this is for the check of the read-back
    }
    std::optional<TilePlan> tiles;
    if (f.shape.fill == Fill::Tiles && ids.splatCount > 0) {
        tiles = planTiles(ids, backend_->info());
        if (!tiles) log(LogLevel::Info, "{} x {} px, {} splats: the lists of compute tiles do not fit the device, quads fill this size", ids.widthPx, ids.heightPx, ids.splatCount);
    }
    if (tiles) {
        DPL_TRY(ids.tileLists, makeBuffer(f.owned, "tile lists", tiles->listBytes));
        DPL_CHECK_OK(backend_->write(ids.tileLists, 0, kZero));  // the same
        DPL_TRY(ids.tileEntries, makeBuffer(f.owned, "tile entries", tiles->entryBytes));
        DPL_TRY(ids.tilePixels, makeBuffer(f.owned, "tile pixels", tiles->pixelBytes));
    }
    for (Slot& slot : f.slots) { DPL_CHECK_OK(buildSlot(row, f, slot, tiles)); }
    return {};
}

Status GpuRenderer::buildSlot(const Row& row, ShapedFrame& f, Slot& slot, const std::optional<TilePlan>& tiles) {
    std::vector<FrameIds> subjects;
    for (size_t k = 0; k < row.members.size(); ++k) {
        const LoadedAvatar& a = avatars_.at(row.members[k]);
        slot.frame.emplace_back(), slot.palette.emplace_back();
        DPL_TRY(slot.frame[k], makeBuffer(f.owned, "frame", sizeof(gpu::FrameData), BufferMemory::Upload));
        if (a.data) { DPL_TRY(slot.palette[k], makeBuffer(f.owned, "palette", paletteRows(*a.data) * sizeof(gpu::vec4), BufferMemory::Upload)); }
        subjects.push_back(f.ids.of(row.subjects[k]));
        subjects[k].frame = slot.frame[k], subjects[k].palette = slot.palette[k];
    }
    if (f.shape.sceneDepth) { DPL_TRY(slot.scene, makeBuffer(f.owned, "scene depth", uint64_t(f.shape.widthPx) * f.shape.heightPx * f.shape.views * 4, BufferMemory::Upload)); }
    DPL_TRY(slot.finalCounts, makeBuffer(f.owned, "final counts", sizeof(gpu::FrameCounts), BufferMemory::Readback));
    FrameIds ids = f.ids;
    ids.scene = slot.scene;

    FramePlan plan(*backend_);
    plan.fill("begin", ids.counts, 0);
    for (const FrameIds& subject : subjects) {
        if (!subject.general && subject.vertexCount > 0 && (subject.splatCount > 0 || ids.meshDepth)) addSkin(plan, subject);
        if (ids.meshDepth) addMeshDepth(plan, subject);
    }
    for (const FrameIds& subject : subjects) {
        if (subject.splatCount == 0) continue;
        if (!subject.general) {
            addTriangles(plan, subject);
            addChunks(plan, subject);
        }
        addProject(plan, subject);
    }
    if (ids.splatCount > 0) {
        addCompact(plan, ids);
        addSort(plan, ids);
        if (tiles) addTiles(plan, ids, *tiles);
    } else {  // no work, but the draw still clears the target: its arguments are zero
        plan.fill("no pairs", ids.pairs, 0);
        plan.fill("no splats", ids.projected, 0);
    }
    addDraw(plan, ids);
    plan.copy("counts", ids.counts, slot.finalCounts);
    DPL_TRY(slot.draw, plan.finish());
    return {};
}

Status GpuRenderer::buildReadback(ShapedFrame& f) {
    FrameIds& ids = f.ids;
    const uint64_t pixels = uint64_t(ids.widthPx) * ids.heightPx * ids.viewCount;
    if (!ids.colourPixels) { DPL_TRY(ids.colourPixels, makeBuffer(f.owned, "colour pixels", pixels * 4, BufferMemory::Readback)); }
    if (ids.depth && !ids.depthPixels) { DPL_TRY(ids.depthPixels, makeBuffer(f.owned, "depth pixels", pixels * (backend_->info().halfDepth ? 4 : 8), BufferMemory::Readback)); }
    FramePlan plan(*backend_);
    plan.readback("readback", ids.target, ids.colourPixels, ids.depthPixels);
    if (ids.meshDepth) {
        if (!ids.meshDepthPixels) { DPL_TRY(ids.meshDepthPixels, makeBuffer(f.owned, "mesh depth pixels", pixels * 4, BufferMemory::Readback)); }
        plan.copy("mesh readback", ids.meshDepth, ids.meshDepthPixels);
    }
    DPL_TRY(f.readback, plan.finish());
    return {};
}

Result<GpuRenderer::ShapedFrame*> GpuRenderer::frameOf(Row& row, const Shape& shape) {
    for (ShapedFrame& f : row.frames)
        if (f.shape == shape) return &f;
    if (row.frames.size() >= kFramesKept) {
        const auto oldest = std::min_element(row.frames.begin(), row.frames.end(), [](const auto& x, const auto& y) { return x.lastUse < y.lastUse; });
        freeFrame(*oldest);
        row.frames.erase(oldest);
    }
    ShapedFrame f;
    f.shape = shape;
    if (auto status = build(row, f); !status) {
        freeFrame(f);
        return status.error();
    }
    row.frames.push_back(std::move(f));
    return &row.frames.back();
}

void GpuRenderer::freeFrame(ShapedFrame& f) {
    for (const Slot& slot : f.slots) backend_->destroyFrame(slot.draw);
    backend_->destroyFrame(f.readback);
    backend_->destroyTarget(f.ids.target);
    for (BufferId id : f.owned) backend_->destroyBuffer(id);
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
        if (row->second.holds(id)) freeRow(row->second), row = rows_.erase(row);
        else ++row;
    }
    freeBuffers(it->second.owned);
    avatars_.erase(it);
}

/** The row of these avatars; made when they are drawn together for the first time, and the one not used for longest goes. */
Result<GpuRenderer::Row*> GpuRenderer::rowOf(std::span<const Drawn> what) {
    if (what.empty() || what.size() > kMaxDrawnTogether) return fail(Code::InvalidArgument, "{} avatars; 1 to {} are drawn together", what.size(), kMaxDrawnTogether);
    for (const Drawn& d : what)
        if (!avatars_.contains(d.avatar)) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", d.avatar);
    if (what.size() == 1) return &rows_.at(what[0].avatar);
    size_t together = 0;
    auto oldest = rows_.end();
    for (auto it = rows_.begin(); it != rows_.end(); ++it) {
        Row& row = it->second;
        if (std::equal(what.begin(), what.end(), row.members.begin(), row.members.end(), [](const Drawn& d, RenderAvatarId member) { return d.avatar == member; })) return &row;
        if (row.members.size() == 1) continue;
        ++together;
        if (oldest == rows_.end() || row.lastUse < oldest->second.lastUse) oldest = it;
    }
    Row row;
    for (const Drawn& d : what) {
        if (row.holds(d.avatar)) return fail(Code::InvalidArgument, "avatar {} is named twice; it has one pose", d.avatar);
        row.members.push_back(d.avatar), row.subjects.push_back(avatars_.at(d.avatar).ids);
    }
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
    DPL_TRY(Row* row, rowOf(what));
    bool mesh = false;
    uint32_t samples = 1;
    for (const Drawn& d : what) {
        const auto& data = avatars_.at(d.avatar).data;
        mesh |= data != nullptr;
        if (data && backend_->info().fourSamples) samples = std::max(samples, coverageSamples(data->trainedPixelM, rootPosition(data->joints, *d.pose), views));
    }
    if (wants.meshDepth && !mesh) return fail(Code::InvalidArgument, "general splats have no mesh and no depth of one");
    avatars_.at(what[0].avatar).lastRow = 0;
    std::fill(std::begin(row->drawn), std::end(row->drawn), 0);
    const Fill fill = samples == 1 ? options_.fill : Fill::Quads;  // tiles have one sample a pixel
    const Shape shape{views[0].widthPx, views[0].heightPx, uint32_t(views.size()), wants.depth, wants.meshDepth, wants.behindScene(), 0, samples, fill};
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

Status GpuRenderer::drawFrame(Row& row, std::span<const Drawn> what, std::span<const Cameraf> views, const Shape& shape, std::span<const std::span<const float>> sceneDepthM) {
    DPL_TRY(ShapedFrame* frame, frameOf(row, shape));
    Slot& slot = frame->slots[frame->next];
    if (!backend_->finished(slot.draw)) {
        ++waits_;
        DPL_CHECK_OK(backend_->wait(slot.draw));
    }
    fill(row, slot, what, views, shape.samples);
    if (shape.sceneDepth) writeScene(slot, shape, sceneDepthM);
    DPL_CHECK_OK(backend_->submit(slot.draw));
    frame->next = (frame->next + 1) % kFramesInFlight;
    slot.number = frame->lastUse = row.lastUse = row.drawn[shape.eye] = ++frameNumber_;
    return {};
}

void GpuRenderer::fill(const Row& row, const Slot& slot, std::span<const Drawn> what, std::span<const Cameraf> views, uint32_t samples) {
    for (size_t k = 0; k < row.members.size(); ++k) {
        const LoadedAvatar& avatar = avatars_.at(row.members[k]);
        const gpu::FrameData block = packFrame(avatar.splats, views, samples);
        std::memcpy(backend_->mapped(slot.frame[k]).data(), &block, sizeof(block));
        if (avatar.data) writePalette(*avatar.data, *what[k].pose, slot.palette[k]);
    }
}

void GpuRenderer::writeScene(const Slot& slot, const Shape& shape, std::span<const std::span<const float>> sceneDepthM) {
    const size_t pixels = size_t(shape.widthPx) * shape.heightPx;
    float* to = reinterpret_cast<float*>(backend_->mapped(slot.scene).data());
    for (size_t v = 0; v < shape.views; ++v, to += pixels) {
        const std::span<const float> from = sceneDepthM[v];
        if (from.empty()) std::fill_n(to, pixels, INFINITY);
        else std::transform(from.begin(), from.begin() + ptrdiff_t(pixels), to, farthestSeenM);
    }
}

void GpuRenderer::writePalette(const AvatarData& avatar, const Pose& pose, BufferId palette) {
    jointTransforms(avatar.joints, pose, worldFromRest_);
    nodes_.clear();
    if (!avatar.correctives.empty()) {
        correctiveCoefficients(avatar.correctives, pose, coefficients_);
        correctiveNodes(avatar.correctives, coefficients_, nodes_);
    }
    packPalette(worldFromRest_, nodes_, {reinterpret_cast<gpu::vec4*>(backend_->mapped(palette).data()), paletteRows(avatar)});
}

GpuRenderer::Row* GpuRenderer::frameRow(const LoadedAvatar& avatar) {
    const auto row = rows_.find(avatar.lastRow);
    return avatar.lastRow == 0 || row == rows_.end() ? nullptr : &row->second;
}

Result<std::span<const PixelView>> GpuRenderer::read(RenderAvatarId id) {
    const auto it = avatars_.find(id);
    if (it == avatars_.end()) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", id);
    Row* row = frameRow(it->second);
    if (!row) return fail(Code::InvalidArgument, "nothing was drawn of avatar {}", id);
    size_t views = 0;
    for (const uint64_t number : row->drawn) {
        if (number == 0) continue;
        const auto drawn = std::find_if(row->frames.begin(), row->frames.end(), [&](const ShapedFrame& f) { return f.lastUse == number; });
        if (drawn == row->frames.end()) return fail(Code::Internal, "frame {} of avatar {} is gone", number, id);
        ShapedFrame& frame = *drawn;
        if (!frame.readback) { DPL_CHECK_OK(buildReadback(frame)); }
        DPL_CHECK_OK(backend_->run(frame.readback));
        frame.lastRead = frame.lastUse;
        takePixels(frame, views);
        views += frame.shape.views;
    }
    if (views == 0) return fail(Code::InvalidArgument, "nothing was drawn of avatar {}", id);
    return std::span<const PixelView>(pixels_, views);
}

bool GpuRenderer::idle(RenderAvatarId id) {
    for (const auto& [number, row] : rows_)
        for (const ShapedFrame& frame : row.frames)
            for (const Slot& slot : frame.slots)
                if (row.holds(id) && !backend_->finished(slot.draw)) return false;
    return true;
}

Result<FrameStats> GpuRenderer::stats(RenderAvatarId id) {
    const auto it = avatars_.find(id);
    if (it == avatars_.end()) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", id);
    FrameStats stats;
    stats.residentBytes = backend_->residentBytes();
    stats.waits = waits_;
    stats.avatarBytes = it->second.avatarBytes, stats.splatBytes = it->second.splatBytes;
    const Row* row = frameRow(it->second);
    if (!row) return stats;
    const auto slotOf = [&](auto isIt) -> std::pair<const ShapedFrame*, const Slot*> {
        std::pair<const ShapedFrame*, const Slot*> found{};
        for (const ShapedFrame& frame : row->frames)
            for (const Slot& slot : frame.slots)
                if (slot.number > (found.second ? found.second->number : 0) && backend_->finished(slot.draw) && isIt(frame, slot)) found = {&frame, &slot};
        return found;
    };
    const auto add = [&](const ShapedFrame& frame, const Slot& slot) {
        gpu::FrameCounts counts;
        std::memcpy(&counts, backend_->mapped(slot.finalCounts).data(), sizeof(counts));
        const auto raise = [](uint32_t& value, uint32_t other) { value = std::max(value, other); };
        stats.views += frame.shape.views;
        stats.chunks = frame.ids.filledGroups;
        raise(stats.trianglesInView, counts.trianglesInView), raise(stats.trianglesFacing, counts.trianglesFacing), raise(stats.chunksProjected, counts.chunksProjected);
        raise(stats.splatsInView, counts.splatsInView), raise(stats.splatsFacing, counts.splatsFacing), raise(stats.splatsDrawn, counts.visible);
        // From survivors and layout: the GPU counts no bytes. Of several avatars the widest SH entry counts for all.
        uint64_t shBytes = 0;
        for (const SubjectIds& subject : row->subjects) {
            stats.bytesDecided += uint64_t(subject.codes.firstPlace - subject.codes.firstParent) * 4;
            shBytes = std::max<uint64_t>(shBytes, (subject.codes.firstShIndex ? 2 : 0) + subject.codes.shWords * 4);
        }
        if (counts.splatsFacing > 0) {
            stats.bytesDecided += uint64_t(counts.chunksProjected) * gpu::kSplatGroup * 5;
            stats.bytesDecoded += uint64_t(counts.splatsFacing) * 4 + uint64_t(counts.visible) * (4 + shBytes);
        }
        stats.tileEntries += counts.tileEntries;
        stats.tilesOverflowed |= counts.tilesOverflowed != 0;
        for (PassTime& pass : backend_->passTimes(slot.draw)) stats.passes.push_back(std::move(pass));
        if (frame.lastRead == slot.number)
            for (PassTime& pass : backend_->passTimes(frame.readback)) stats.passes.push_back(std::move(pass));
    };
    const auto [frame, slot] = slotOf([](const ShapedFrame&, const Slot&) { return true; });
    if (!frame) return stats;
    if (frame->shape.eye == 1) {  // the other eye of the canted pair ran just before
        const auto [first, firstSlot] = slotOf([number = slot->number](const ShapedFrame& f, const Slot& s) { return f.shape.eye == 0 && s.number + 1 == number; });
        if (first) add(*first, *firstSlot);
    }
    add(*frame, *slot);
    return stats;
}

void GpuRenderer::takePixels(const ShapedFrame& f, size_t firstView) {
    const size_t pixels = size_t(f.shape.widthPx) * f.shape.heightPx;
    const std::byte* colour = backend_->mapped(f.ids.colourPixels).data();
    const std::byte* depth = f.shape.depth ? backend_->mapped(f.ids.depthPixels).data() : nullptr;
    const bool half = backend_->info().halfDepth;
    for (size_t v = 0; v < f.shape.views; ++v) {
        std::vector<float>& depthM = depthM_[firstView + v];
        depthM.resize(depth ? pixels : 0);
        for (size_t i = 0; i < depthM.size(); ++i) {
            float sums[2];  // Σ α T z, Σ α T
            if (half) {
                uint16_t raw[2];
                std::memcpy(raw, depth + (v * pixels + i) * 4, 4);
                sums[0] = floatFromHalf(raw[0]), sums[1] = floatFromHalf(raw[1]);
            } else {
                std::memcpy(sums, depth + (v * pixels + i) * 8, 8);
            }
            depthM[i] = sums[1] > 0 ? sums[0] / sums[1] : 0.0f;
        }
        std::vector<float>& meshDepthM = meshDepthM_[firstView + v];
        meshDepthM.resize(f.shape.meshDepth ? pixels : 0);
        if (f.shape.meshDepth) {
            std::memcpy(meshDepthM.data(), backend_->mapped(f.ids.meshDepthPixels).data() + v * pixels * 4, pixels * 4);
            std::replace(meshDepthM.begin(), meshDepthM.end(), INFINITY, 0.0f);
        }
        pixels_[firstView + v] = {f.shape.widthPx, f.shape.heightPx, {reinterpret_cast<const uint8_t*>(colour) + v * pixels * 4, pixels * 4}, depthM, meshDepthM};
    }
}

}  // namespace dpl
