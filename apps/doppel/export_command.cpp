// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "apps/shared/pictures.h"
#include "reconstruction/output/package/export_mesh.h"
#include "reconstruction/output/package/posed_splats.h"

namespace dpl {

void addExportCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<ExportOptions>();
    auto mesh = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand(
        "export", "Write one posed frame as general splats for other viewers, or the skinned mesh, or convert general splats");
    command
        ->add_option("avatar", options->avatar,
                     "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")
        ->required();
    command->add_option("-o,--out", options->out, "A .ply (INRIA layout) or a .glb (KHR_gaussian_splatting; with --mesh: skinned mesh)")
        ->required()
        ->check(isOutputFile({".ply", ".glb"}));
    command->add_option("--clip", options->clip, "A clip of the avatar by name, or a BVH or glTF file; default: the rest pose");
    command->add_option("--animation", options->animation, kAnimationHelp)->needs("--clip");
    command->add_option("--time", options->timeS, "Time in the clip, seconds")->check(inRange(0.0, 1e6))->needs("--clip");
    command
        ->add_flag("--mesh", *mesh,
                   "Write the mesh without splats, with normals, vertex colours, skeleton and the avatar's clips, for any glTF viewer")
        ->excludes("--clip");
    command->footer(
        "Examples:\n"
        "  doppel export ada/avatar.glb -o ada.ply\n"
        "  doppel export ada/avatar.glb -o stride.glb --clip 02_01.bvh --time 0.8\n"
        "  doppel export ada/avatar.glb --mesh -o ada-mesh.glb\n"
        "  doppel export guitar.spz -o guitar.ply\n"
        "The mesh is unlit (KHR_materials_unlit): its colours contain the light of the scan, and viewers show them as photographed.");
    command->callback([options, mesh, &run] {
        refuseInputAsOutput(options->out, {options->avatar, options->clip});
        run = [options, mesh] {
            auto line = *mesh ? exportMesh(options->avatar, options->out) : exportPosedSplats(*options);
            if (!line) return reportError(line.error());
            std::printf("%s\n", line->c_str());
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
