// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/shared/pictures.h"
#include "reconstruction/output/package/inspect.h"
#include "reconstruction/run/clothes_in_motion.h"

namespace dpl {

void addInspectCommand(CLI::App& app, CommandRun& run) {
    auto path = std::make_shared<std::filesystem::path>(), clip = std::make_shared<std::filesystem::path>();
    auto animation = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand(
        "inspect", "Show the content of an avatar and the bytes of its parts, or the content of a file of general splats");
    command
        ->add_option("avatar", *path,
                     "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")
        ->required();
    command->add_option("--clip", *clip, "Show instead how the clothes fare in a motion: a BVH or glTF file");
    command->add_option("--animation", *animation, kAnimationHelp)->needs("--clip");
    command->add_flag("--json", *json, "Print JSON instead of a table");
    command->footer(
        "Examples:\n  doppel inspect ada/avatar.glb\n  doppel inspect ada/avatar.glb --json | jq .bytes\n  doppel inspect "
        "ada/avatar.glb --clip walk.bvh\n  doppel inspect guitar.compressed.ply");
    command->callback([path, clip, animation, json, &run] {
        run = [path, clip, animation, json] {
            if (!clip->empty()) {
                Progress progress(*json ? Progress::Style::Quiet : Progress::Style::Usual);
                const auto found = clothesInMotion(*path, *clip, *animation, *json, progress);
                if (!found) return reportError(found.error());
                std::printf("%s\n", found->c_str());
                return int(kExitOk);
            }
            const auto found = *json ? inspectAsJson(*path) : inspectAsText(*path);
            if (!found) return reportError(found.error());
            std::printf("%s\n", found->text.c_str());
            if (found->intact) return int(kExitOk);
            return reportError(fail(Code::CorruptData, "{}: the content hash does not match, the file was damaged or edited; copy it again",
                                    path->string()));
        };
    });
}

}  // namespace dpl
