// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/export_skinned_splats.h"

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/avatar/cloth_bounds.h"
#include "sdk/core/files.h"
#include "sdk/format/gltf_mesh.h"

namespace dpl {

Result<std::string> exportSkinnedSplats(const std::filesystem::path& avatar, const std::filesystem::path& out) {
    if (out.extension() != ".glb")
        return fail(Code::InvalidArgument, "-o {}: with --skinned-splats the file must end in .glb", out.string());
    DPL_TRY(const auto bytes, readAvatarBytes(avatar));
    DPL_TRY(AvatarData data, avatarOf(avatar, bytes, "skinned splats"));
    boundGarments(data.joints, data.mesh);  // as renderers load it
    const auto file = writeGltfSkinnedSplats(data, vertexNormals(data.mesh.restPositions, data.mesh.triangles));
    if (!file) return fail(file.error().code, "{}: {}", avatar.string(), file.error().message);
    DPL_RETURN_IF_ERROR(writeFileAtomically(out, *file));
    std::string lines;
    if (!data.correctives.empty() || !data.light.empty())
        lines = formatText("not in {}:{}{}{}; DPL_skinned_gaussian_splatting holds splats on a skinned mesh and no more\n",
                           out.filename().string(), data.correctives.followsPose() ? " pose correctives" : "",
                           data.expressions.empty() ? "" : " expressions", data.light.empty() ? "" : " light");
    return lines + formatText("{} splats of SH degree {}, {} meshes, {} vertices, {} triangles, {} joints, {} clips, {} bytes in {}",
                              data.splats.count(), data.splats.shDegree, data.mesh.layers.size(), data.mesh.restPositions.size(),
                              data.mesh.triangles.size(), data.joints.size(), data.clips.size(), file->size(), out.string());
}

}  // namespace dpl
