// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/beside_tool.h"
#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/evaluate.h"

namespace dpl {

void addEvaluateCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<EvaluateOptions>();
    CLI::App* command = app.add_subcommand("evaluate", "Score an avatar on the held-out frames of its scan");
    command->add_option("scan", options->scan, "The scan that the avatar was made from")->required();
    command->add_option("avatar", options->avatar, "Avatar file (.glb)")->required();
    command->add_option("-o,--out", options->out, "Folder for report.html and report.json; default: print a summary only");
    command->add_option("--poses", options->poses, "poses.json of the reconstruction (default: beside the avatar)");
    command->add_flag("--ladder", options->ladder,
                      "Replace stages by the truth in turn, on scans that have one (docs/reference/metrics.md)");
    command->add_option("--lpips", options->lpips, "Weights of LPIPS (.npz), for scans of a published protocol (docs/reference/neuman.md)");
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core. The result is the same for any number")
        ->check(inRange(0, 256));
    command->footer(
        "Examples:\n"
        "  doppel evaluate scan ada/avatar.glb\n"
        "  doppel evaluate scan ada/avatar.glb --ladder -o ada/ladder");
    command->callback([options, &run] {
        run = [options] {
            options->web = webFolder();
            Progress progress;
            const auto summary = evaluateAvatar(*options, progress);
            if (!summary) return reportError(summary.error());
            std::printf("%s\n", summary->c_str());
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
