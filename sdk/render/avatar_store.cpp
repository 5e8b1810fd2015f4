// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/avatar_store.h"

#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"

namespace dpl {
namespace {

Status uploadAvatar(LoadedSubject& subject, const CodedSplats& splats, const AvatarRecords& records) {
    SubjectIds& ids = subject.ids;
    if (ids.corrected) {
        DPL_TRY(ids.vertices, subject.buffers.upload<gpu::CorrectedVertexRecord>("vertices", records.correctedVertices));
    } else {
        DPL_TRY(ids.vertices, subject.buffers.upload<gpu::VertexRecord>("vertices", records.vertices));
    }
    DPL_TRY(ids.triangles, subject.buffers.upload<gpu::TriangleRecord>("triangles", records.triangles));
    DPL_TRY(ids.splats, subject.buffers.upload<uint32_t>("splats", records.codes));
    DPL_TRY(ids.posed, subject.buffers.create("posed", ids.vertexCount * uint64_t(sizeof(gpu::vec4))));
    DPL_TRY(ids.triangleFrames, subject.buffers.create("triangle frames", ids.triangleCount * uint64_t(sizeof(gpu::TriangleFrame))));
    subject.splatBytes = splats.bytes();
    subject.residentBytes = splats.bytes() + posingBytes(*subject.avatar) + records.triangles.size() * sizeof(gpu::TriangleRecord) +
                            records.vertices.size() * sizeof(gpu::VertexRecord) +
                            records.correctedVertices.size() * sizeof(gpu::CorrectedVertexRecord);
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

Result<RenderAvatarId> AvatarStore::addAvatar(std::shared_ptr<const AvatarData> avatar) {
    if (!avatar) return fail(Code::InvalidArgument, "no avatar");
    DPL_CHECK_OK(checkSplatArrays(*avatar));
    DPL_TRY(CodedSplats coded, codeSplats(avatar->mesh, avatar->splats));
    return addCodedAvatar(std::move(avatar), std::move(coded));
}

Result<RenderAvatarId> AvatarStore::addCodedAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) {
    if (!avatar) return fail(Code::InvalidArgument, "no avatar");
    DPL_CHECK_OK(checkAvatar(*avatar, splats, backend_.info()));
    measureDetail(*avatar, splats);
    AvatarRecords records = packAvatar(*avatar, splats);
    LoadedSubject subject(backend_);
    subject.splats = splatSetOf(*avatar, splats);
    subject.detail = DetailSubject(*avatar, splats);
    subject.ids = countsOf(*avatar, splats);
    subject.ids.codes = records.where;
    if (cullComponents_) subject.components = std::move(records.components);
    subject.ids.componentCount = subject.components.count();
    subject.avatar = std::move(avatar);
    DPL_CHECK_OK(uploadAvatar(subject, splats, records));
    return keep(std::move(subject));
}

Result<RenderAvatarId> AvatarStore::addSplats(const StaticSplatData& splats) {
    DPL_CHECK_OK(checkSplats(splats, backend_.info()));
    LoadedSubject subject(backend_);
    subject.splats = splatSetOf(splats);
    subject.ids = countsOf(splats);
    // Files keep the order of training, where neighbours in memory are far apart in space. Sorted, a group is compact and its loads
    // coherent.
    const std::vector<uint32_t> order = spatialOrder(splats.position);
    subject.generalDetail = GeneralDetailSubject(measureGroups(splats, order), splats.count());
    const std::vector<gpu::vec4> records = packSplats(splats, order, subject.generalDetail.groups());
    const std::vector<gpu::uvec4> sh = packSh(splats, order);
    DPL_TRY(subject.ids.splats, subject.buffers.upload<gpu::vec4>("splats", records));
    DPL_TRY(subject.ids.sh, subject.buffers.upload<gpu::uvec4>("sh", sh));
    subject.residentBytes = subject.splatBytes = records.size() * sizeof(gpu::vec4) + sh.size() * sizeof(gpu::uvec4);
    return keep(std::move(subject));
}

RenderAvatarId AvatarStore::keep(LoadedSubject subject) {
    subjects_.emplace(++lastId_, std::move(subject));
    return lastId_;
}

LoadedSubject* AvatarStore::find(RenderAvatarId id) {
    const auto found = subjects_.find(id);
    return found == subjects_.end() ? nullptr : &found->second;
}

}  // namespace dpl
