// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/avatar_store.h"

#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_detail.h"

namespace dpl {
namespace {

/** A subject without its buffers, and the records that add() uploads. */
struct PreparedUpload final : PreparedSubject {
    PreparedUpload(Backend& backend, const AvatarStore* owner) : owner(owner), subject(backend) {}

    const AvatarStore* owner;
    LoadedSubject subject;
    AvatarRecords avatar;                   // of an avatar
    std::vector<gpu::uvec4> generalSplats;  // of general splats
    std::vector<gpu::uvec4> sh;
};

Status uploadAvatar(LoadedSubject& subject, const AvatarRecords& records) {
    SubjectIds& ids = subject.ids;
    if (ids.corrected) {
        DPL_TRY(ids.vertices, subject.buffers.upload<gpu::CorrectedVertexRecord>("vertices", records.correctedVertices));
    } else {
        DPL_TRY(ids.vertices, subject.buffers.upload<gpu::VertexRecord>("vertices", records.vertices));
    }
    DPL_TRY(ids.triangles, subject.buffers.upload<gpu::TriangleRecord>("triangles", records.triangles));
    DPL_TRY(ids.splats, subject.buffers.upload<uint32_t>("splats", records.codes));
    DPL_TRY(ids.posed, subject.buffers.create("posed", ids.vertexCount * uint64_t(sizeof(gpu::PosedVertex))));
    DPL_TRY(ids.triangleFrames, subject.buffers.create("triangle frames", ids.triangleCount * uint64_t(sizeof(gpu::TriangleFrame))));
    return {};
}

Status uploadSplats(LoadedSubject& subject, const PreparedUpload& records) {
    DPL_TRY(subject.ids.splats, subject.buffers.upload<gpu::uvec4>("splats", records.generalSplats));
    DPL_TRY(subject.ids.sh, subject.buffers.upload<gpu::uvec4>("sh", records.sh));
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
    auto prepared = std::make_unique<PreparedUpload>(backend_, this);
    AvatarRecords& records = prepared->avatar = packAvatar(*avatar, splats);
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
    return std::unique_ptr<PreparedSubject>(std::move(prepared));
}

Result<std::unique_ptr<PreparedSubject>> AvatarStore::prepareSplats(const StaticSplatData& splats) const {
    DPL_CHECK_OK(checkSplats(splats, backend_.info()));
    auto prepared = std::make_unique<PreparedUpload>(backend_, this);
    LoadedSubject& subject = prepared->subject;
    subject.splats = splatSetOf(splats);
    subject.ids = countsOf(splats);
    // Files have the order of training: neighbours in memory are far apart in space. Sorted by space, a group is compact and its loads
    // are coherent.
    const std::vector<uint32_t> order = spatialOrder(splats.position);
    subject.generalDetail = GeneralDetailSubject(measureGroups(splats, order), splats.count());
    prepared->generalSplats = packSplats(splats, order, subject.generalDetail.groups());
    prepared->sh = packSh(splats, order);
    subject.residentBytes = subject.splatBytes =
        prepared->generalSplats.size() * sizeof(gpu::uvec4) + prepared->sh.size() * sizeof(gpu::uvec4);
    return std::unique_ptr<PreparedSubject>(std::move(prepared));
}

Result<RenderAvatarId> AvatarStore::add(std::unique_ptr<PreparedSubject> prepared) {
    auto* upload = dynamic_cast<PreparedUpload*>(prepared.get());
    if (!upload || upload->owner != this) return fail(Code::InvalidArgument, "the subject was prepared by another renderer");
    LoadedSubject& subject = upload->subject;
    DPL_CHECK_OK(subject.avatar ? uploadAvatar(subject, upload->avatar) : uploadSplats(subject, *upload));
    subjects_.emplace(++lastId_, std::move(subject));
    return lastId_;
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
