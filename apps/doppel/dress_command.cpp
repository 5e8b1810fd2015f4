// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "reconstruction/output/dress/dress.h"
#include "reconstruction/run/progress.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

struct DressOptions {
    std::filesystem::path avatar, out;
    std::array<std::filesystem::path, kDressLayers.size()> from;  // empty: the layer stays as it is
    uint32_t threadCount = 0;
};

Status dress(const DressOptions& options) {
    std::vector<GarmentFile> garments;
    for (size_t i = 0; i < kDressLayers.size(); ++i)
        if (!options.from[i].empty()) garments.push_back({kDressLayers[i], options.from[i]});
    Jobs jobs(options.threadCount);
    Progress progress;
    progress.beginStage("dress");
    ShownTask task(progress);
    const TaskScope scope(&task);
    DPL_TRY(const DressedFile result, dressFiles(options.avatar, garments, jobs));
    DPL_RETURN_IF_ERROR(writeFileAtomically(options.out, result.bytes));
    progress.endStage(formatText("{} bytes", result.bytes.size()));
    for (const DressedLayer& layer : result.dressed.layers) {
        std::printf("%-7s %s from %s: %u triangles, %u splats, moved by %.1f mm on average\n", layer.layer.c_str(),
                    layer.replaced ? "replaced by the one" : "added", layer.file.c_str(), layer.triangles, layer.splats,
                    1e3 * double(layer.meanMoveM));
        if (layer.insideBody > 0)
            std::printf("        %u vertices still lie inside the body: the garment is too tight for it there\n", layer.insideBody);
    }
    if (result.dressed.noSkin)
        std::printf("skin    the avatar shows no skin, so uncovered skin has no colour and is left out\n");
    else
        std::printf("skin    %u triangles that no picture showed take the colour of the skin around them\n",
                    result.dressed.filledSkinTriangles);
    std::printf("%s: %zu bytes\n", options.out.c_str(), result.bytes.size());
    return {};
}

}  // namespace

void addDressCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<DressOptions>();
    CLI::App* command = app.add_subcommand("dress", "Put garments of other avatars on an avatar");
    command->add_option("avatar", options->avatar, "Avatar that is dressed (.glb)")->required();
    command->add_option("-o,--out", options->out, "The dressed avatar (.glb)")->required()->check(isOutputFile({".glb"}));
    for (size_t i = 0; i < kDressLayers.size(); ++i)
        command->add_option(formatText("--{}", kDressLayers[i]), options->from[i],
                            formatText("Avatar whose {} it puts on", kDressLayers[i]));
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core. The result is the same for any number")
        ->check(inRange(0, 256));
    command->footer(
        "Examples:\n"
        "  doppel dress ada/avatar.glb --top ben/avatar.glb -o ada-in-bens-shirt.glb\n"
        "  doppel dress ada/avatar.glb --top ben/avatar.glb --bottom cleo/avatar.glb -o ada-new.glb\n"
        "  doppel inspect ada-new.glb                    the layers, and where they come from\n"
        "Both avatars need clothes as layers (a scan with label pictures) and the same body model. The garment is refitted to the new "
        "body\n"
        "and pushed out of it; its splats move along. A layer that the avatar lacks is added. Skin that the change uncovers and that no\n"
        "picture showed takes the colour of the skin around it.");
    command->callback([options, &run] {
        refuseInputAsOutput(options->out, {options->avatar});
        refuseInputAsOutput(options->out, {options->from.begin(), options->from.end()});
        run = [options] {
            Status done = dress(*options);
            return done ? int(kExitOk) : reportError(done.error());
        };
    });
}

}  // namespace dpl
