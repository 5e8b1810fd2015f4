// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/avatar_store.h"

#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_detail.h"

namespace dpl {
namespace {

/** A subject without its buffers. */
struct PreparedUpload final : PreparedSubject {
    explicit PreparedUpload(const AvatarStore* owner) : owner(owner) {}

    const AvatarStore* owner;
    LoadedSubject subject;
};

Status uploadAvatar(SubjectIds& ids, const AvatarRecords& records, DeviceBuffers& buffers) {
    if (ids.corrected) {
        DPL_TRY(ids.vertices, buffers.upload<gpu::CorrectedVertexRecord>("vertices", records.correctedVertices));
    } else {
        DPL_TRY(ids.vertices, buffers.upload<gpu::VertexRecord>("vertices", records.vertices));
    }
    DPL_TRY(ids.triangles, buffers.upload<gpu::TriangleRecord>("triangles", records.triangles));
    DPL_TRY(ids.splats, buffers.upload<uint32_t>("splats", records.codes));
    DPL_TRY(ids.posed, buffers.create("posed", ids.vertexCount * uint64_t(sizeof(gpu::PosedVertex))));
    DPL_TRY(ids.triangleFrames, buffers.create("triangle frames", ids.triangleCount * uint64_t(sizeof(gpu::TriangleFrame))));
    return {};
}

Status uploadSplats(SubjectIds& ids, const SubjectRecords& records, DeviceBuffers& buffers) {
    DPL_TRY(ids.splats, buffers.upload<gpu::uvec4>("splats", records.generalSplats));
    DPL_TRY(ids.sh, buffers.upload<gpu::uvec4>("sh", records.sh));
    return {};
}

SubjectIds countsOf(const AvatarData& avatar, const CodedSplats& splats) {
    SubjectIds ids;
    ids.vertexCount = uint32_t(avatar.mesh.restPositions.size());
    ids.triangleCount = uint32_t(avatar.mesh.triangles.size());
    ids.jointCount = uint32_t(avatar.joints.size());
    ids.corrected = !avatar.correctives.empty();
    ids.paletteSize = uint32_t(paletteSize(avatar));
    ids.splatCount = splats.count();
    ids.shDegree = splats.shDegree;
    ids.groupCount = 2 * uint32_t(splats.chunks.size());
    for (const SplatChunk& c : splats.chunks) ids.filledGroups += (c.splatCount + gpu::kSplatGroup - 1) / gpu::kSplatGroup;
    ids.mayTakeFourSamples = avatar.trainedPixelM > 0;
    return ids;
}

SubjectIds countsOf(const StaticSplatData& splats) {
    SubjectIds ids;
    ids.general = true;
    ids.wide = reachFar(splats);
    ids.splatCount = splats.count();
    ids.shDegree = splats.shDegree;
    ids.groupCount = (ids.splatCount + gpu::kSplatGroup - 1) / gpu::kSplatGroup;
    return ids;
}

}  // namespace

Result<std::unique_ptr<PreparedSubject>> AvatarStore::prepareAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) const {
    if (!avatar) return fail(Code::InvalidArgument, "no avatar");
    DPL_CHECK_OK(checkAvatar(*avatar, splats, backend_.info()));
    measureDetail(*avatar, splats);
    auto prepared = std::make_unique<PreparedUpload>(this);
    auto kept = std::make_shared<SubjectRecords>();
    AvatarRecords& records = kept->avatar = packAvatar(*avatar, splats);
    LoadedSubject& subject = prepared->subject;
    subject.splats = splatSetOf(*avatar, splats);
    subject.detail = DetailSubject(*avatar, splats);
    subject.ids = countsOf(*avatar, splats);
    subject.ids.codes = records.where;
    if (cullComponents_) subject.components = std::move(records.components);
    subject.ids.componentCount = subject.components.count();
    subject.splatBytes = splats.bytes();
    subject.residentBytes = splats.bytes() + posingBytes(*avatar) + records.triangles.size() * sizeof(gpu::TriangleRecord) +
                            records.vertices.size() * sizeof(gpu::VertexRecord) +
                            records.correctedVertices.size() * sizeof(gpu::CorrectedVertexRecord);
    subject.avatar = std::move(avatar);
    subject.records = std::move(kept);
    return std::unique_ptr<PreparedSubject>(std::move(prepared));
}

Result<std::unique_ptr<PreparedSubject>> AvatarStore::prepareSplats(const StaticSplatData& splats) const {
    DPL_CHECK_OK(checkSplats(splats, backend_.info()));
    auto prepared = std::make_unique<PreparedUpload>(this);
    LoadedSubject& subject = prepared->subject;
    subject.splats = splatSetOf(splats);
    subject.ids = countsOf(splats);
    // Files have the order of training: neighbours in memory are far apart in space. Sorted by space, a group is compact and its loads
    // are coherent.
    const std::vector<uint32_t> order = spatialOrder(splats.position);
    subject.generalDetail = GeneralDetailSubject(measureGroups(splats, order), splats.count());
    auto kept = std::make_shared<SubjectRecords>();
    kept->generalSplats = packSplats(splats, order, subject.generalDetail.groups());
    kept->sh = packSh(splats, order);
    subject.residentBytes = subject.splatBytes = kept->bytes();
    subject.records = std::move(kept);
    return std::unique_ptr<PreparedSubject>(std::move(prepared));
}

Result<RenderAvatarId> AvatarStore::add(std::unique_ptr<PreparedSubject> prepared) {
    auto* upload = dynamic_cast<PreparedUpload*>(prepared.get());
    if (!upload || upload->owner != this) return fail(Code::InvalidArgument, "the subject was prepared by another renderer");
    DPL_CHECK_OK(this->upload(upload->subject));
    subjects_.emplace(++lastId_, std::move(upload->subject));
    return lastId_;
}

Status AvatarStore::addAll(const AvatarStore& other) {
    for (const auto& [id, subject] : other.subjects_) {
        LoadedSubject copy = subject;
        DPL_CHECK_OK(upload(copy));
        subjects_.emplace(id, std::move(copy));
    }
    lastId_ = other.lastId_;
    return {};
}

/** Gives the subject buffers of its own. */
Status AvatarStore::upload(LoadedSubject& subject) {
    subject.buffers = std::make_shared<DeviceBuffers>(backend_);
    return subject.avatar ? uploadAvatar(subject.ids, subject.records->avatar, *subject.buffers)
                          : uploadSplats(subject.ids, *subject.records, *subject.buffers);
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
