// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/export_mesh.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/output/package/exported_motion.h"
#include "reconstruction/output/package/mesh_atlas.h"
#include "reconstruction/output/package/mesh_morphs.h"
#include "reconstruction/output/package/meshopt_glb.h"
#include "reconstruction/output/package/t_pose.h"
#include "reconstruction/output/package/texture_bake.h"
#include "reconstruction/output/package/texture_views.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/avatar/cloth_bounds.h"
#include "sdk/avatar/humanoid.h"
#include "sdk/core/files.h"
#include "sdk/core/task.h"
#include "sdk/format/gltf_mesh.h"

namespace dpl {
namespace {

constexpr float kHeadDensity = 2, kHandDensity = 1.5f;              // texels a metre, over those of the rest
constexpr float kHiddenDensity = 0.25f;                             // of what lies under clothes in the pose at rest
constexpr float kFinestPixelM = 0.0005f, kCoarsestPixelM = 0.005f;  // of pictures for the texture
constexpr float kLookPixelM = 0.004f;                               // of pictures that only tell what is seen
constexpr int kJpegQuality = 92;
constexpr double kLookEnd = 0.05, kLayEnd = 0.1, kBakeEnd = 0.95;  // of the progress, ends

float densityOf(TexturePart part) {
    return part == TexturePart::Other ? 1 : part == TexturePart::Head ? kHeadDensity : kHandDensity;
}

std::array<float, kTextureParts> pixelsFor(float texelM) {
    std::array<float, kTextureParts> out;
    for (size_t part = 0; part < kTextureParts; ++part)
        out[part] = std::clamp(texelM / densityOf(TexturePart(part)), kFinestPixelM, kCoarsestPixelM);
    return out;
}

std::vector<AtlasKind> kindsOf(const AvatarData& avatar, std::span<const Vec3f> positions, std::span<const TexturePart> part) {
    std::array<float, kTextureParts> pixelM;
    for (size_t p = 0; p < kTextureParts; ++p) pixelM[p] = kLookPixelM / densityOf(TexturePart(p));
    const std::vector<bool> seen = seenTriangles(positions, avatar.mesh.triangles, textureViews(positions, part, pixelM));
    std::vector<AtlasKind> out;
    for (uint32_t l = 0; l < avatar.mesh.layers.size(); ++l)
        for (uint32_t t = 0; t < avatar.mesh.layers[l].triangleCount; ++t) {
            const uint32_t triangle = avatar.mesh.layers[l].firstTriangle + t;
            out.push_back({l, seen[triangle] ? densityOf(part[avatar.mesh.triangles[triangle].x]) : kHiddenDensity});
        }
    return out;
}

}  // namespace

std::string wrongMeshExport(const MeshExportOptions& options) {
    const std::string out = options.out.string();
    if (!options.vrmAuthor) return options.out.extension() == ".glb" ? "" : formatText("-o {}: with --mesh the file must end in .glb", out);
    if (options.out.extension() != ".vrm") return formatText("-o {}: with --vrm the file must end in .vrm", out);
    if (options.vrmAuthor->empty()) return "a VRM names its author; give --author";
    if (!options.clip.empty()) return "--clip does not go with --vrm: programs that take a VRM bring their own motion";
    return options.compression == "none" ? "" : "--compress does not go with --vrm: programs that take a VRM may not know it";
}

Result<std::string> exportMesh(const MeshExportOptions& options, std::span<const TrainFrame> photographs) {
    if (const std::string wrong = wrongMeshExport(options); !wrong.empty()) return fail(Code::InvalidArgument, "{}", wrong);
    DPL_TRY(const auto bytes, readAvatarBytes(options.avatar));
    DPL_TRY(AvatarData data, avatarOf(options.avatar, bytes, "mesh"));
    const auto inFile = [&](const Error& error) { return fail(error.code, "{}: {}", options.avatar.string(), error.message); };
    if (data.splats.count() == 0) return inFile({Code::InvalidArgument, "the avatar has no splats to take a texture from"});
    const std::optional<VrmAbout> vrm = options.vrmAuthor ? std::optional(VrmAbout{*options.vrmAuthor}) : std::nullopt;
    if (vrm) {
        assignHumanoidBones(data.joints);
        if (const Status demanded = checkVrmBones(data.joints); !demanded) return inFile(demanded.error());
    }
    boundGarments(data.joints, data.mesh);  // as renderers load it
    if (!options.clip.empty()) {
        ExportedMotion motion(data);
        DPL_RETURN_IF_ERROR(motion.open(options.clip, options.animation));
        data.clips = {*motion.clip()};
    }

    DrawnAtRest drawn = drawnAtRest(data);
    std::vector<Vec3f>& positions = drawn.positions;
    const std::vector<TexturePart> part = partOfVertices(data);
    std::vector<AtlasKind> kinds;
    {
        const TaskPart look(0, kLookEnd);
        DPL_RETURN_IF_ERROR(taskAt(0, "looking at what is seen"));
        kinds = kindsOf(data, positions, part);
    }
    auto atlas = [&] {
        const TaskPart lay(kLookEnd, kLayEnd);
        return layOutAtlas(positions, data.mesh.triangles, kinds, options.texturePx);
    }();
    if (!atlas) return inFile(atlas.error());
    Jobs jobs(options.threadCount);
    auto texture = [&] {
        const TaskPart bake(kLayEnd, kBakeEnd);
        return bakeTexture(data, positions, *atlas, textureViews(positions, part, pixelsFor(atlas->texelM)), photographs, jobs);
    }();
    if (!texture) return inFile(texture.error());

    const TaskPart write(kBakeEnd, 1);
    DPL_RETURN_IF_ERROR(taskAt(0, "writing"));
    const bool jpeg = options.textureFormat == "jpg";
    auto image =
        jpeg ? encodeJpeg(*texture, atlas->sidePx, atlas->sidePx, 3, kJpegQuality) : encodePng(*texture, atlas->sidePx, atlas->sidePx, 3);
    if (!image) return inFile(image.error());
    data.mesh.restPositions = std::move(positions);
    if (vrm) restInTPose(data, drawn.expressed, jobs);
    const std::vector<Vec3f> restNormals = vertexNormals(data.mesh.restPositions, data.mesh.triangles);
    SeamedMesh seamed = splitAtSeams(data.mesh, *atlas);
    if (options.compression == "meshopt") orderForMeshopt(seamed);
    const std::vector<MeshMorph> morphs = morphsOf(data.mesh.restPositions, drawn.expressed, data.mesh.triangles, seamed.old);
    AvatarData out;
    out.name = data.name, out.joints = std::move(data.joints), out.clips = std::move(data.clips), out.mesh = std::move(seamed.mesh);
    std::vector<Vec3f> normals;
    for (const uint32_t v : seamed.old) normals.push_back(restNormals[v]);
    auto file = writeGltfMesh(out, normals, {seamed.uv, *image, jpeg},
                              {.draco = options.compression == "draco", .vrm = vrm ? &*vrm : nullptr, .morphs = morphs});
    if (file && options.compression == "meshopt") file = compressByMeshopt(*file);
    if (!file) return inFile(file.error());
    DPL_RETURN_IF_ERROR(writeFileAtomically(options.out, *file));
    return formatText(
        "{} meshes, {} vertices, {} triangles, {} joints, {} clips, {} expressions, texture {} × {} in {} charts, a texel {} mm, {} bytes "
        "in {}",
        out.mesh.layers.size(), out.mesh.restPositions.size(), out.mesh.triangles.size(), out.joints.size(), out.clips.size(),
        morphs.size(), atlas->sidePx, atlas->sidePx, atlas->chartCount, std::round(atlas->texelM * 10000) / 10, file->size(),
        options.out.string());
}

}  // namespace dpl
