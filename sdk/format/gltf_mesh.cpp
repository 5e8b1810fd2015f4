// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/gltf_mesh.h"

#include <cmath>

#include "sdk/format/avatar_check.h"
#include "sdk/format/skinned_mesh_write.h"
#include "sdk/format/skinned_splats_write.h"
#include "sdk/format/vrm_write.h"

namespace dpl {
namespace {

Status checkMesh(const AvatarData& avatar, std::span<const Vec3f> normals) {
    constexpr float kUnitError = 1e-4f;  // of a length; a normal in floats has 1e-7
    if (avatar.mesh.layers.empty()) return fail(Code::InvalidArgument, "the avatar has no mesh to write");
    if (normals.size() != avatar.mesh.restPositions.size())
        return fail(Code::InvalidArgument, "{} normals for {} vertices", normals.size(), avatar.mesh.restPositions.size());
    for (size_t v = 0; v < normals.size(); ++v)
        if (!(std::abs(glm::length(normals[v]) - 1) < kUnitError)) return fail(Code::InvalidArgument, "normal {} is not of unit length", v);
    return {};
}

/** addMore(glb, avatar): what the file holds beside mesh, skeleton and clips. */
template <class AddMore>
Result<std::vector<uint8_t>> write(const AvatarData& avatar, const LayerOptions& options, AddMore&& addMore) try {
    AvatarData snapped = avatar;
    snapAvatar(snapped);
    GlbBuilder glb;
    glb.root["asset"] = {{"version", "2.0"}, {"generator", "Doppel"}};
    glb.root["extensionsUsed"] = Json::array();
    DPL_RETURN_IF_ERROR(addLayers(glb, snapped, options));
    addSkeletonAndClips(glb, snapped);
    DPL_RETURN_IF_ERROR(addMore(glb, snapped));
    DPL_RETURN_IF_ERROR(checkGlbSize(glb));
    return glb.finish([](std::string&, std::span<const uint8_t>) {});
} catch (const std::bad_alloc&) {
    return outOfMemory("write a mesh");
} catch (const std::exception& e) {
    return fail(Code::Internal, "the mesh could not be written: {}", e.what());
}

}  // namespace

Result<std::vector<uint8_t>> writeGltfMesh(const AvatarData& avatar, std::span<const Vec3f> normals, const MeshTexture& texture, bool draco,
                                           const VrmAbout* vrm) {
    DPL_RETURN_IF_ERROR(checkAvatarWithoutSplats(avatar));
    DPL_RETURN_IF_ERROR(checkMesh(avatar, normals));
    if (texture.uv.size() != avatar.mesh.restPositions.size())
        return fail(Code::InvalidArgument, "{} texture coordinates for {} vertices", texture.uv.size(), avatar.mesh.restPositions.size());
    for (size_t v = 0; v < texture.uv.size(); ++v)
        if (const Vec2f& at = texture.uv[v]; !(at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1))
            return fail(Code::InvalidArgument, "texture coordinate {} is not from 0 to 1", v);
    return write(avatar, {.draco = draco, .normals = normals, .texture = texture},
                 [&](GlbBuilder& glb, const AvatarData& snapped) { return vrm ? addVrm(glb, snapped, *vrm) : Status(); });
}

Result<std::vector<uint8_t>> writeGltfSkinnedSplats(const AvatarData& avatar, std::span<const Vec3f> normals) {
    DPL_RETURN_IF_ERROR(checkAvatar(avatar));
    DPL_RETURN_IF_ERROR(checkMesh(avatar, normals));
    if (avatar.splats.count() == 0) return fail(Code::InvalidArgument, "the avatar has no splats to write");
    return write(avatar, {.draco = false, .normals = normals, .texture = {}}, [](GlbBuilder& glb, const AvatarData& snapped) {
        addSkinnedSplats(glb, snapped);
        return Status();
    });
}

}  // namespace dpl
