// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/gltf_mesh.h"

#include <cmath>

#include "sdk/format/avatar_check.h"
#include "sdk/format/expression_names.h"
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

Status checkMorphs(std::span<const MeshMorph> morphs, size_t vertexCount) {
    const auto finite = [](const Vec3f& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    for (size_t m = 0; m < morphs.size(); ++m) {
        const MeshMorph& morph = morphs[m];
        if (morph.expression >= kExpressionCount || (m > 0 && morph.expression <= morphs[m - 1].expression))
            return fail(Code::InvalidArgument, "morph {} is expression {} of {}; each is there once, in rising order", m,
                        int(morph.expression), kExpressionCount);
        const char* name = kExpressionNames[morph.expression];
        if (morph.offsetsM.size() != morph.vertices.size() || morph.turns.size() != morph.vertices.size())
            return fail(Code::InvalidArgument, "the arrays of morph '{}' differ in length", name);
        for (size_t i = 0; i < morph.vertices.size(); ++i) {
            if (morph.vertices[i] >= vertexCount || (i > 0 && morph.vertices[i] <= morph.vertices[i - 1]))
                return fail(Code::InvalidArgument, "morph '{}' moves vertex {} of {}; each is there once, in rising order", name,
                            morph.vertices[i], vertexCount);
            if (!finite(morph.offsetsM[i]) || !finite(morph.turns[i]))
                return fail(Code::InvalidArgument, "morph '{}' moves vertex {} by what is no number", name, morph.vertices[i]);
        }
    }
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

Result<std::vector<uint8_t>> writeGltfMesh(const AvatarData& avatar, std::span<const Vec3f> normals, const MeshTexture& texture,
                                           const GltfMeshOptions& options) {
    DPL_RETURN_IF_ERROR(checkAvatarWithoutSplats(avatar));
    DPL_RETURN_IF_ERROR(checkMesh(avatar, normals));
    DPL_RETURN_IF_ERROR(checkMorphs(options.morphs, avatar.mesh.restPositions.size()));
    if (texture.uv.size() != avatar.mesh.restPositions.size())
        return fail(Code::InvalidArgument, "{} texture coordinates for {} vertices", texture.uv.size(), avatar.mesh.restPositions.size());
    for (size_t v = 0; v < texture.uv.size(); ++v)
        if (const Vec2f& at = texture.uv[v]; !(at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1))
            return fail(Code::InvalidArgument, "texture coordinate {} is not from 0 to 1", v);
    return write(avatar, {.draco = options.draco, .normals = normals, .texture = texture, .morphs = options.morphs},
                 [&](GlbBuilder& glb, const AvatarData& snapped) {
                     return options.vrm ? addVrm(glb, snapped, *options.vrm, options.morphs) : Status();
                 });
}

Result<std::vector<uint8_t>> writeGltfSkinnedSplats(const AvatarData& avatar, std::span<const Vec3f> normals) {
    DPL_RETURN_IF_ERROR(checkAvatar(avatar));
    DPL_RETURN_IF_ERROR(checkMesh(avatar, normals));
    if (avatar.splats.count() == 0) return fail(Code::InvalidArgument, "the avatar has no splats to write");
    return write(avatar, {.draco = false, .normals = normals, .texture = {}, .morphs = {}}, [](GlbBuilder& glb, const AvatarData& snapped) {
        addSkinnedSplats(glb, snapped);
        return Status();
    });
}

}  // namespace dpl
