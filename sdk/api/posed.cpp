// SPDX-License-Identifier: Apache-2.0
// Posed splats and vertices in buffers of the program.
#include "sdk/api/posed.h"

#include <algorithm>
#include <cmath>

#include "sdk/api/buffer_layout.h"
#include "sdk/api/scene.h"
#include "sdk/api/surface.h"
#include "sdk/draw/check_draw.h"

namespace dpl::api {
namespace {

static_assert(DPL_SPLAT_POSITION == int(SplatNumbers::Position) && DPL_SPLAT_ROTATION == int(SplatNumbers::Rotation) &&
              DPL_SPLAT_SCALE == int(SplatNumbers::Scale) && DPL_SPLAT_COVARIANCE == int(SplatNumbers::Covariance) &&
              DPL_SPLAT_OPACITY == int(SplatNumbers::Opacity) && DPL_SPLAT_COLOUR == int(SplatNumbers::Colour) &&
              DPL_SPLAT_SH == int(SplatNumbers::Sh));

struct SplatRequest {
    uint32_t budget = 0, shDegree = 0;
    std::optional<Vec3f> eye;
};

Result<SplatRequest> requestOf(const DplSplatOptions* options) {
    SplatRequest request;
    if (options == nullptr) return request;
    DPL_TRY(const DplSplatOptions given, readStruct<DplSplatOptions>(options, "options"));
    if (given.shDegree > kMaxShDegree)
        return fail(Code::InvalidArgument, "SH of degree {}; 0 to {} are possible", given.shDegree, kMaxShDegree);
    request.budget = given.splatBudget, request.shDegree = given.shDegree;
    if (given.eye == nullptr) return request;
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(given.eye[axis]) <= kMaxDistanceM))
            return fail(Code::InvalidArgument, "the eye is at ({}, {}, {}); up to {} m from the origin is possible", given.eye[0],
                        given.eye[1], given.eye[2], kMaxDistanceM);
    request.eye = Vec3f(given.eye[0], given.eye[1], given.eye[2]);
    return request;
}

std::array<BufferProperty, 7> splatProperties(uint32_t shDegree) {
    std::array<BufferProperty, 7> out = {
        {{"position", 0}, {"rotation", 0}, {"scale", 0}, {"covariance", 0}, {"opacity", 0}, {"colour", 0}, {"SH", 0}}};
    for (size_t p = 0; p < out.size(); ++p) out[p].numbers = numbersOf(SplatNumbers(p), shDegree);
    return out;
}

/** Made by the first call. */
PosedOutput& outputOf(Avatar& avatar) {
    Surface& surface = surfaceOf(avatar);
    if (!surface.output) surface.output = std::make_shared<PosedOutput>();
    return *surface.output;
}

/** The splats that a budget keeps; how many. */
uint32_t choose(PosedOutput& output, const Avatar& avatar, const CodedSplats& splats, uint32_t budget) {
    if (output.chosenFor == budget) return output.chosen;
    SplatDetail detail;
    if (budget > 0 && budget < splats.count()) {
        if (!output.detail) output.detail.emplace(*avatar.data, splats);
        detail.perM2 = std::nextafter(float(output.detail->densityWithin(budget)), 0.0f);
        detail.shShare = output.detail->shShare(detail.perM2);
    }
    output.chosen = output.writer.choose(splats, detail);
    output.chosenFor = budget;
    return output.chosen;
}

/** The posed triangles, in avatar space; those of hidden layers show nothing. */
std::span<const TriangleFrame<float>> framesOf(PosedOutput& output, Avatar& avatar) {
    const AvatarData& data = *avatar.data;
    const Pose& pose = avatar.stiffPose();
    if (output.posed && samePose(output.pose, pose) && output.hiddenLayers == avatar.hiddenLayers) return output.mesh.frames();
    if (output.normals.empty() && !data.light.empty()) output.normals = restVertexNormals(data.mesh);
    output.mesh.pose({data.joints, data.mesh, data.correctives, {}, &data.light, output.normals, &avatar.surface->clearance}, pose,
                     output.jobs);
    const std::vector<LayerData>& layers = data.mesh.layers;
    for (size_t l = 0; l < std::min<size_t>(layers.size(), 64); ++l)
        if (avatar.hiddenLayers >> l & 1) output.mesh.hideTriangles(layers[l].firstTriangle, layers[l].triangleCount);
    output.pose = pose, output.hiddenLayers = avatar.hiddenLayers, output.posed = true;
    return output.mesh.frames();
}

Status writeSplats(Avatar& avatar, const SplatRequest& request, const DplBuffer* buffer, DplWritten* written) {
    DPL_RETURN_IF_ERROR(checkUsable(*avatar.context));
    const CodedSplats* splats = avatar.context->renderer->splatsOf(avatar.renderId);
    if (splats == nullptr)
        return fail(Code::Unsupported, "the splats are in the memory of the GPU; load the avatar with a context of DPL_RENDERER_SOFTWARE");
    PosedOutput& output = outputOf(avatar);
    DplWritten out{};
    out.count = choose(output, avatar, *splats, request.budget);
    if (buffer == nullptr) return writeStruct(written, out, "written");
    DPL_TRY(const BufferColumns layout, columnsOf(buffer, splatProperties(request.shDegree), out.count));
    DPL_RETURN_IF_ERROR(writeStruct(written, out, "written"));
    SplatColumn columns[DPL_MAX_BUFFER_ELEMENTS];
    for (uint32_t c = 0; c < layout.count; ++c) columns[c] = {SplatNumbers(layout.columns[c].property), layout.columns[c].to};
    avatar.clock.show(avatar.data->correctives.motion, avatar.pose);
    out.saturated = output.writer.write(*splats, framesOf(output, avatar), avatar.placement, {columns, layout.count}, request.eye,
                                        request.shDegree, output.jobs);
    return writeStruct(written, out, "written");
}

Status writeMesh(Avatar& avatar, const DplBuffer* buffer, DplWritten* written) {
    static constexpr BufferProperty kProperties[] = {{"position", 3}, {"normal", 3}};
    const AvatarData& data = *avatar.data;
    DplWritten out{};
    out.count = uint32_t(data.mesh.restPositions.size());
    if (buffer == nullptr) return writeStruct(written, out, "written");
    DPL_TRY(const BufferColumns layout, columnsOf(buffer, kProperties, out.count));
    DPL_RETURN_IF_ERROR(writeStruct(written, out, "written"));
    avatar.clock.show(data.correctives.motion, avatar.pose);
    const std::span<const Vec3f> vertices = verticesOf(avatar);
    PosedOutput& output = outputOf(avatar);
    const Placement& placed = avatar.placement;
    for (const BufferColumn& column : layout.all()) {
        const bool normals = column.property == DPL_VERTEX_NORMAL;
        if (normals) {
            if (!output.restNormals) output.restNormals.emplace(data.mesh);
            output.restNormals->compute(vertices, data.mesh.triangles, output.meshNormals);
        }
        for (size_t v = 0; v < vertices.size(); ++v) {
            const Vec3f world(normals ? placed.rotation * Vec3d(output.meshNormals[v]) : placed.toWorld(Vec3d(vertices[v])));
            out.saturated += column.to.write(v, &world.x, 3);
        }
    }
    return writeStruct(written, out, "written");
}

}  // namespace
}  // namespace dpl::api

using namespace dpl;
using namespace dpl::api;

extern "C" DplResult dplWriteSplats(DplAvatar avatar, const DplSplatOptions* options, const DplBuffer* buffer, DplWritten* written) {
    return guarded("dplWriteSplats", [&]() -> Status {
        DPL_TRY(const SplatRequest request, requestOf(options));
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        return writeSplats(*found, request, buffer, written);
    });
}

extern "C" DplResult dplWriteMesh(DplAvatar avatar, const DplBuffer* buffer, DplWritten* written) {
    return guarded("dplWriteMesh", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        return writeMesh(*found, buffer, written);
    });
}
