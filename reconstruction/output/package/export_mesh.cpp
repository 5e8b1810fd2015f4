// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/export_mesh.h"

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/files.h"
#include "sdk/format/gltf_mesh.h"

namespace dpl {

Result<std::string> exportMesh(const std::filesystem::path& avatar, const std::filesystem::path& out) {
    if (out.extension() != ".glb") return fail(Code::InvalidArgument, "-o {}: with --mesh the file must end in .glb", out.string());
    DPL_TRY(const auto bytes, readAvatarBytes(avatar));
    DPL_TRY(const AvatarData data, avatarOf(avatar, bytes, "mesh"));
    auto file = writeGltfMesh(data, vertexNormals(data.mesh.restPositions, data.mesh.triangles));
    if (!file) return fail(file.error().code, "{}: {}", avatar.string(), file.error().message);
    DPL_RETURN_IF_ERROR(writeFileAtomically(out, *file));
    return formatText("{} meshes, {} vertices, {} triangles, {} joints, {} clips, {} bytes in {}", data.mesh.layers.size(),
                      data.mesh.restPositions.size(), data.mesh.triangles.size(), data.joints.size(), data.clips.size(), file->size(),
                      out.string());
}

}  // namespace dpl
