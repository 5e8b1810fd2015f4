// SPDX-License-Identifier: Apache-2.0
// Posed splats and vertices in buffers of the program.
#include "sdk/api/posed.h"

#include <algorithm>

#include "sdk/api/buffer_layout.h"
#include "sdk/api/scene.h"
#include "sdk/api/splat_request.h"
#include "sdk/api/surface.h"

namespace dpl::api {
namespace {

/** Made by the first call. */
PosedOutput& outputOf(Avatar& avatar) {
    Surface& surface = surfaceOf(avatar);
    if (!surface.output) surface.output = std::make_shared<PosedOutput>();
    return *surface.output;
}

/** The splats that a budget keeps; how many. */
uint32_t choose(PosedOutput& output, const Avatar& avatar, const CodedSplats& splats, uint32_t budget) {
    if (output.chosenFor == budget) return output.chosen;
    const bool thins = budget > 0 && budget < splats.count();
    if (thins && !output.detail) output.detail.emplace(*avatar.data, splats);
    output.chosen = output.writer.choose(splats, thins ? output.detail->detailWithin(budget) : SplatDetail());
    output.chosenFor = budget;
    return output.chosen;
}

/** The posed triangles, in avatar space; those of hidden layers show nothing. */
std::span<const TriangleFrame<float>> framesOf(PosedOutput& output, Avatar& avatar) {
    const AvatarData& data = *avatar.data;
    const Pose& pose = avatar.drawnPose();
    if (output.posed && samePose(output.pose, pose) && output.hiddenLayers == avatar.hiddenLayers) return output.mesh.frames();
    if (output.normals.empty() && !data.light.empty()) output.normals = restVertexNormals(data.mesh);
    output.mesh.pose({data.joints, data.mesh, data.correctives, {}, &data.light, output.normals, &avatar.surface->cloth, &data.expressions},
                     pose, output.jobs);
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
