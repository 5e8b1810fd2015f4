// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/avatar_store.h"

#include "sdk/core/task.h"
#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_detail.h"

namespace dpl {
namespace {

/** A subject without its buffers. */
struct PreparedUpload final : PreparedSubject {
    explicit PreparedUpload(const AvatarStore* owner) : owner(owner) {}

    const AvatarStore* owner;
    LoadedSubject subject;

    /** Records, what posing writes, and the lists of the subject alone. */
    uint64_t bytes() const override {
        constexpr uint64_t kRounding = 4096;  // by the device, of fifteen buffers together
        FrameIds alone;
        alone.allSplats = subject.ids.splatCount, alone.allGroups = subject.ids.groupCount, alone.wide = subject.wide;
        return subject.records->bytes() + subject.ids.vertexCount * uint64_t(sizeof(gpu::PosedVertex)) +
               subject.ids.triangleCount * uint64_t(sizeof(gpu::TriangleFrame)) + alone.listBytes() + kRounding;
    }
};

/** Makes a buffer for `items`, which are uploaded to it later. */
template <class T>
Result<BufferId> bufferFor(const char* label, const std::vector<T>& items, DeviceBuffers& buffers, std::vector<UploadPiece>& pieces) {
    DPL_TRY(const BufferId id, buffers.create(label, items.size() * sizeof(T)));
    pieces.push_back({id, std::as_bytes(std::span(items))});
    return id;
}

Status makeAvatarBuffers(SubjectIds& ids, const AvatarRecords& records, DeviceBuffers& buffers, std::vector<UploadPiece>& pieces) {
    if (ids.corrected) {
        DPL_TRY(ids.vertices, bufferFor("vertices", records.correctedVertices, buffers, pieces));
    } else {
        DPL_TRY(ids.vertices, bufferFor("vertices", records.vertices, buffers, pieces));
    }
    DPL_TRY(ids.triangles, bufferFor("triangles", records.triangles, buffers, pieces));
    DPL_TRY(ids.splats, bufferFor("splats", records.codes, buffers, pieces));
    DPL_TRY(ids.posed, buffers.create("posed", ids.vertexCount * uint64_t(sizeof(gpu::PosedVertex))));
    DPL_TRY(ids.triangleFrames, buffers.create("triangle frames", ids.triangleCount * uint64_t(sizeof(gpu::TriangleFrame))));
    return {};
}

Status makeSplatBuffers(SubjectIds& ids, const SubjectRecords& records, DeviceBuffers& buffers, std::vector<UploadPiece>& pieces) {
    DPL_TRY(ids.splats, bufferFor("splats", records.generalSplats, buffers, pieces));
    DPL_TRY(ids.sh, bufferFor("sh", records.sh, buffers, pieces));
    return {};
}

SubjectIds countsOf(const AvatarData& avatar, const CodedSplats& splats) {
    SubjectIds ids;
    ids.vertexCount = uint32_t(avatar.mesh.restPositions.size());
    ids.triangleCount = uint32_t(avatar.mesh.triangles.size());
    ids.jointCount = uint32_t(avatar.joints.size());
    ids.corrected = !avatar.correctives.empty();
    ids.firstLight = firstLightRow(avatar);
    ids.splatCount = splats.count();
    ids.shDegree = splats.shDegree;
    ids.groupCount = 2 * uint32_t(splats.chunks.size());
    return ids;
}

SubjectIds countsOf(const StaticSplatData& splats) {
    SubjectIds ids;
    ids.general = true;
    ids.splatCount = splats.count();
    ids.shDegree = splats.shDegree;
    ids.groupCount = (ids.splatCount + gpu::kSplatGroup - 1) / gpu::kSplatGroup;
    return ids;
}

}  // namespace

Result<std::unique_ptr<PreparedSubject>> AvatarStore::prepareAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) const {
    if (!avatar) return fail(Code::InvalidArgument, "no avatar");
    DPL_RETURN_IF_ERROR(checkAvatar(*avatar, splats, backend_.info()));
    DPL_RETURN_IF_ERROR(taskAt(0.1));
    measureDetail(*avatar, splats);
    DPL_RETURN_IF_ERROR(taskAt(0.4));
    auto prepared = std::make_unique<PreparedUpload>(this);
    auto kept = std::make_shared<SubjectRecords>();
    AvatarRecords& records = kept->avatar = packAvatar(*avatar, splats);
    LoadedSubject& subject = prepared->subject;
    subject.splats = splatSetOf(*avatar, splats);
    subject.detail = DetailSubject(*avatar, splats);
    subject.ids = countsOf(*avatar, splats);
    subject.ids.codes = records.where;
    subject.components = std::move(records.components);
    for (const SplatChunk& c : splats.chunks) subject.filledGroups += (c.splatCount + gpu::kSplatGroup - 1) / gpu::kSplatGroup;
    subject.paletteSize = uint32_t(paletteSize(*avatar));
    subject.splatBytes = splats.bytes();
    subject.residentBytes = splats.bytes() + posingBytes(*avatar) + records.triangles.size() * sizeof(gpu::TriangleRecord) +
                            records.vertices.size() * sizeof(gpu::VertexRecord) +
                            records.correctedVertices.size() * sizeof(gpu::CorrectedVertexRecord);
    subject.cloth = ClothLimits(avatar->joints, avatar->mesh, avatar->correctives);
    subject.avatar = std::move(avatar);
    subject.records = std::move(kept);
    return std::unique_ptr<PreparedSubject>(std::move(prepared));
}

Result<std::unique_ptr<PreparedSubject>> AvatarStore::prepareSplats(const StaticSplatData& splats) const {
    DPL_RETURN_IF_ERROR(checkSplats(splats, backend_.info()));
    auto prepared = std::make_unique<PreparedUpload>(this);
    LoadedSubject& subject = prepared->subject;
    subject.splats = splatSetOf(splats);
    subject.ids = countsOf(splats);
    subject.wide = reachFar(splats);
    DPL_RETURN_IF_ERROR(taskAt(0.1));
    // Files have the order of training: neighbours in memory are far apart in space. Sorted by space, a group is compact and its loads
    // are coherent.
    const std::vector<uint32_t> order = spatialOrder(splats.position);
    DPL_RETURN_IF_ERROR(taskAt(0.3));
    subject.generalDetail = GeneralDetailSubject(measureGroups(splats, order), splats.count());
    DPL_RETURN_IF_ERROR(taskAt(0.5));
    auto kept = std::make_shared<SubjectRecords>();
    {
        const TaskPart part(0.5, 0.7);
        kept->generalSplats = packSplats(splats, order, subject.generalDetail.groups());
    }
    {
        const TaskPart part(0.7, 1);
        kept->sh = packSh(splats, order);
    }
    DPL_RETURN_IF_ERROR(taskAt(1));
    subject.residentBytes = subject.splatBytes = kept->bytes();
    subject.records = std::move(kept);
    return std::unique_ptr<PreparedSubject>(std::move(prepared));
}

Result<RenderAvatarId> AvatarStore::begin(std::unique_ptr<PreparedSubject> prepared) {
    auto* mine = dynamic_cast<PreparedUpload*>(prepared.get());
    if (!mine || mine->owner != this) return fail(Code::InvalidArgument, "the subject was prepared by another renderer");
    DPL_RETURN_IF_ERROR(makeBuffers(mine->subject));
    subjects_.emplace(++lastId_, std::move(mine->subject));
    return lastId_;
}

Result<double> AvatarStore::continueUpload(RenderAvatarId id, UploadSlice& slice) {
    slice = {};
    LoadedSubject* subject = find(id);
    if (!subject) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", id);
    if (!subject->upload) return 1.0;
    DPL_TRY(const double share, subject->upload->next(slice));
    if (share == 1) subject->upload.reset();
    return share;
}

Status AvatarStore::finishUpload(RenderAvatarId id) {
    LoadedSubject* subject = find(id);
    if (!subject) return fail(Code::InvalidArgument, "avatar {} is not in this renderer", id);
    if (!subject->upload) return {};
    DPL_RETURN_IF_ERROR(subject->upload->finish());
    subject->upload.reset();
    return {};
}

Status AvatarStore::addAll(const AvatarStore& other) {
    for (const auto& [id, subject] : other.subjects_) {
        LoadedSubject copy = subject;
        DPL_RETURN_IF_ERROR(makeBuffers(copy));
        subjects_.emplace(id, std::move(copy));
        DPL_RETURN_IF_ERROR(finishUpload(id));
    }
    lastId_ = other.lastId_;
    return {};
}

/** Gives the subject buffers of its own, and an upload that fills them. */
Status AvatarStore::makeBuffers(LoadedSubject& subject) {
    subject.upload.reset();
    subject.buffers = std::make_shared<DeviceBuffers>(backend_);
    std::vector<UploadPiece> pieces;
    DPL_RETURN_IF_ERROR(subject.avatar ? makeAvatarBuffers(subject.ids, subject.records->avatar, *subject.buffers, pieces)
                                       : makeSplatBuffers(subject.ids, *subject.records, *subject.buffers, pieces));
    subject.upload = std::make_shared<SubjectUpload>(backend_, std::move(pieces));
    return {};
}

uint64_t SubjectRecords::bytes() const {
    return avatar.vertices.size() * sizeof(gpu::VertexRecord) + avatar.correctedVertices.size() * sizeof(gpu::CorrectedVertexRecord) +
           avatar.triangles.size() * sizeof(gpu::TriangleRecord) + avatar.codes.size() * sizeof(uint32_t) +
           (generalSplats.size() + sh.size()) * sizeof(gpu::uvec4);
}

LoadedSubject* AvatarStore::find(RenderAvatarId id) {
    const auto found = subjects_.find(id);
    return found == subjects_.end() ? nullptr : &found->second;
}

std::optional<std::span<const JointData>> AvatarStore::jointsOf(RenderAvatarId id) const {
    const auto found = subjects_.find(id);
    if (found == subjects_.end()) return std::nullopt;
    const AvatarData* avatar = found->second.avatar.get();
    return avatar ? std::span<const JointData>(avatar->joints) : std::span<const JointData>();
}

}  // namespace dpl
