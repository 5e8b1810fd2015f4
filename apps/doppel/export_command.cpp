// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "apps/shared/pictures.h"
#include "reconstruction/output/package/export_clip.h"
#include "reconstruction/output/package/export_mesh.h"
#include "reconstruction/output/package/export_skinned_splats.h"
#include "reconstruction/output/package/mesh_atlas.h"
#include "reconstruction/output/package/posed_splats.h"
#include "reconstruction/run/progress.h"
#include "reconstruction/run/run_photographs.h"
#include "sdk/core/numbers.h"

namespace dpl {
namespace {

int exportOneFrame(const ExportOptions& options) {
    Progress progress;
    progress.beginStage("export");
    ShownTask task(progress);
    const TaskScope scope(&task);
    auto lines = exportPosedSplats(options);
    if (!lines) return reportError(lines.error());
    progress.endStage("done");
    std::printf("%s\n", lines->c_str());
    return kExitOk;
}

int exportClip(const ExportOptions& options) {
    Progress progress;
    progress.beginStage("export");
    ShownTask task(progress);
    const TaskScope scope(&task);
    auto clip = ClipExport::open(options);
    if (!clip) return reportError(clip.error());
    progress.note((*clip)->plan());
    auto lines = (*clip)->write();
    if (!lines) return reportError(lines.error());
    progress.endStage("done");
    std::printf("%s\n", lines->c_str());
    return kExitOk;
}

CLI::Validator isTextureSize() {
    return CLI::Validator(
        [](const std::string& text) {
            uint32_t side = 0;
            if (readNumber(text, side) && isTexturePx(side)) return std::string();
            return formatText("'{}' is no power of two from {} to {}", text, kLeastTexturePx, kMostTexturePx);
        },
        "POWER OF TWO");
}

/** The scan that an avatar was made of, and where the poses of its frames are; empty: beside the avatar. */
struct PhotographOptions {
    std::filesystem::path scan, poses;
};

int exportTheMesh(const MeshExportOptions& options, const PhotographOptions& from) {
    Progress progress;
    progress.beginStage("export");
    ShownTask task(progress);
    const TaskScope scope(&task);
    std::vector<TrainFrame> photographs;
    if (!from.scan.empty()) {
        auto found = stillPhotographs(options.avatar, from.scan, from.poses);
        if (!found) return reportError(found.error());
        photographs = std::move(*found);
    }
    auto line = exportMesh(options, photographs);
    if (!line) return reportError(line.error());
    progress.endStage("done");
    std::printf("%s\n", line->c_str());
    return kExitOk;
}

int exportSplatsOnMesh(const ExportOptions& options) {
    auto lines = exportSkinnedSplats(options.avatar, options.out);
    if (!lines) return reportError(lines.error());
    std::printf("%s\n", lines->c_str());
    return kExitOk;
}

}  // namespace

void addExportCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<ExportOptions>();
    auto mesh = std::make_shared<bool>(false), skinnedSplats = std::make_shared<bool>(false);
    auto meshOptions = std::make_shared<MeshExportOptions>();
    CLI::App* command = app.add_subcommand(
        "export",
        "Write one posed frame as general splats for other viewers, or the skinned mesh, with a texture or with its splats, or convert "
        "general splats");
    command
        ->add_option("avatar", options->avatar,
                     "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")
        ->required();
    command
        ->add_option("-o,--out", options->out,
                     "A .glb (KHR_gaussian_splatting, the first choice; with --mesh: skinned mesh), a .spz (smallest) or a .ply (INRIA "
                     "layout); with "
                     "--fps a folder")
        ->required()
        ->check(isOutputFile({".glb", ".spz", ".ply", ".vrm"}, /*orFolder=*/true));
    command->add_option("--input-axes", options->inputAxes, "The up axis of general splats, instead of the one that they state")
        ->check(CLI::IsMember(kAxesNames));
    command
        ->add_option("--axes", options->axes,
                     "Axes of a .ply. y-down (default): half a turn about z, for SuperSplat, splat-transform and Babylon.js; y-up: for "
                     "three.js, Spark and "
                     "the PlayCanvas engine. The file states them")
        ->check(CLI::IsMember({"y-down", "y-up"}));
    command->add_option("--spz-version", options->spzVersion, "Version of a .spz; 3 for older readers")
        ->check(CLI::IsMember({3, 4}))
        ->capture_default_str();
    command->add_option("--clip", options->clip, "A clip of the avatar by name, or a BVH or glTF file; default: the rest pose");
    command->add_option("--animation", options->animation, kAnimationHelp)->needs("--clip");
    command->add_option("--time", options->timeS, "Time in the clip, seconds")->check(inRange(0.0, 1e6))->needs("--clip");
    command
        ->add_option("--fps", options->fps,
                     "Write the whole clip, so many frames a second, as a numbered folder of splat files with the same splats in each")
        ->check(inRange(0.01, 1000))
        ->needs("--clip");
    command->add_option("--format", options->format, "With --fps: the format of the files (default: spz)")
        ->check(CLI::IsMember({"spz", "ply", "glb"}))
        ->needs("--fps");
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core. The result is the same for any number")
        ->check(isWholeNumber(256));
    auto* withMesh = command->add_flag("--mesh", *mesh,
                                       "Write the skinned mesh without splats: texture, normals, skeleton, animations, and expressions as "
                                       "morph targets, for any glTF viewer; with --clip that clip alone");
    auto* withSkinned = command->add_flag("--skinned-splats", *skinnedSplats,
                                          "Write the skinned mesh with the splats bound to it, by the open glTF extension "
                                          "DPL_skinned_gaussian_splatting, for engines that pose splats themselves");
    withSkinned->excludes(withMesh)->excludes("--clip");
    for (const char* other : {"--axes", "--input-axes", "--spz-version", "--time", "--fps"})
        withMesh->excludes(other), withSkinned->excludes(other);
    command
        ->add_option(
            "--texture-size", meshOptions->texturePx,
            formatText("With --mesh: side of the texture in pixels, a power of two from {} to {}", kLeastTexturePx, kMostTexturePx))
        ->needs("--mesh")
        ->check(isTextureSize())
        ->capture_default_str();
    command->add_option("--texture-format", meshOptions->textureFormat, "With --mesh: png, or jpg, which is smaller")
        ->needs("--mesh")
        ->check(CLI::IsMember({"png", "jpg"}))
        ->capture_default_str();
    command
        ->add_option(
            "--compress", meshOptions->compression,
            "With --mesh: draco makes the geometry a quarter, for viewers that know KHR_draco_mesh_compression; meshopt: clips and "
            "expressions too, for viewers that know EXT_meshopt_compression; none: for all")
        ->needs("--mesh")
        ->check(CLI::IsMember({"none", "draco", "meshopt"}))
        ->capture_default_str();
    auto from = std::make_shared<PhotographOptions>();
    command
        ->add_option("--photographs", from->scan,
                     "With --mesh: the scan that the avatar was made of; the texture also takes detail of its still photographs, but never "
                     "of held-out ones")
        ->needs("--mesh")
        ->check(CLI::ExistingDirectory);
    command->add_option("--poses", from->poses, "With --photographs: poses.json of the reconstruction (default: beside the avatar)")
        ->needs("--photographs");
    auto author = std::make_shared<std::string>();
    auto vrm = std::make_shared<bool>(false);
    auto* asVrm =
        command
            ->add_flag("--vrm", *vrm,
                       "With --mesh: VRM 1.0 for programs that animate persons: T-pose, humanoid bones, the strictest permissions; "
                       "expressions where the avatar has them; no clips")
            ->needs("--mesh")
            ->excludes("--clip")
            ->excludes("--compress");
    asVrm->needs(command->add_option("--author", *author, "With --vrm: who made the avatar and alone may use it")->needs("--vrm"));
    command->footer(
        "Examples:\n"
        "  doppel export ada/avatar.glb -o ada-splats.glb\n"
        "  doppel export ada/avatar.glb -o stride.glb --clip 02_01.bvh --time 0.8\n"
        "  doppel export ada/avatar.glb -o walk --clip 02_01.bvh --fps 30           (walk/00000.spz, walk/00001.spz ...)\n"
        "  doppel export ada/avatar.glb --mesh -o ada-mesh.glb\n"
        "  doppel export ada/avatar.glb --mesh -o ada-mesh.glb --photographs scan   (with detail that the scan's pictures show)\n"
        "  doppel export ada/avatar.glb --mesh -o ada-walk.glb --clip 02_01.bvh --texture-format jpg\n"
        "  doppel export ada/avatar.glb --mesh -o ada-small.glb --compress meshopt --texture-format jpg\n"
        "  doppel export ada/avatar.glb --skinned-splats -o ada-skinned.glb\n"
        "  doppel export ada/avatar.glb --mesh --vrm --author \"Ada Byron\" -o ada.vrm\n"
        "  doppel export guitar.spz -o guitar.ply\n"
        "  doppel export guitar.ply -o guitar.spz --input-axes y-down\n"
        "The mesh is unlit (KHR_materials_unlit): its colours contain the light of the scan, and viewers show them as photographed.");
    command->callback([options, mesh, skinnedSplats, meshOptions, from, vrm, author, &run] {
        if (options->fps > 0 && options->format.empty()) options->format = "spz";
        refuseInputAsOutput(options->out, {options->avatar, options->clip});
        if (*vrm) meshOptions->vrmAuthor = *author;
        meshOptions->avatar = options->avatar, meshOptions->out = options->out;
        meshOptions->clip = options->clip, meshOptions->animation = options->animation;
        meshOptions->threadCount = options->threadCount;
        const std::string wrong = *mesh ? wrongMeshExport(*meshOptions) : *skinnedSplats ? "" : wrongExport(*options);
        if (!wrong.empty()) throw CLI::ValidationError("--out", wrong);
        run = [options, mesh, skinnedSplats, meshOptions, from] {
            if (*mesh) return exportTheMesh(*meshOptions, *from);
            if (*skinnedSplats) return exportSplatsOnMesh(*options);
            return options->fps > 0 ? exportClip(*options) : exportOneFrame(*options);
        };
    });
}

}  // namespace dpl
