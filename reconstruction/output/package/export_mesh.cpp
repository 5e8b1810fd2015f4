// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/export_mesh.h"

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/files.h"

namespace dpl {

Result<std::string> exportMesh(const std::filesystem::path& avatar, const std::filesystem::path& out, const GltfMeshOptions& options) {
    if (out.extension() != ".glb")
        return fail(Code::InvalidArgument, "-o {}: with --{} the file must end in .glb", out.string(),
                    options.skinnedSplats ? "skinned-splats" : "mesh");
    DPL_TRY(const auto bytes, readAvatarBytes(avatar));
    DPL_TRY(const AvatarData data, avatarOf(avatar, bytes, options.skinnedSplats ? "skinned splats" : "mesh"));
    auto file = writeGltfMesh(data, vertexNormals(data.mesh.restPositions, data.mesh.triangles), options);
    if (!file) return fail(file.error().code, "{}: {}", avatar.string(), file.error().message);
    DPL_RETURN_IF_ERROR(writeFileAtomically(out, *file));
    std::string line;
    if (options.skinnedSplats) {
        if (!data.correctives.empty() || !data.light.empty())
            line =
                formatText("left out:{}{}: {}\n", data.correctives.empty() ? "" : " pose correctives", data.light.empty() ? "" : " light",
                           "DPL_skinned_gaussian_splatting holds splats on a skinned mesh and no more");
        line += formatText("{} splats of SH degree {}, ", data.splats.count(), data.splats.shDegree);
    }
    return line + formatText("{} meshes, {} vertices, {} triangles, {} joints, {} clips, {} bytes in {}", data.mesh.layers.size(),
                             data.mesh.restPositions.size(), data.mesh.triangles.size(), data.joints.size(), data.clips.size(),
                             file->size(), out.string());
}

}  // namespace dpl
