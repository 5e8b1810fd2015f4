// SPDX-License-Identifier: Apache-2.0
// doppel bench: compares time, error and memory of every renderer that a user can choose, on one avatar.
#include "apps/bench/bench.h"
#include "apps/doppel/commands.h"

namespace dpl {

void addBenchCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<BenchOptions>();
    options->renderers = {"software", "vulkan-quads", "vulkan-tiles"};
    CLI::App* command =
        app.add_subcommand("bench", "Time an avatar on every renderer and measure its pictures against the double-precision referee");
    addBenchOptions(*command, *options, {"software", "vulkan", "vulkan-quads", "vulkan-tiles"});
    command->footer(
        "Examples:\n  doppel bench ada/avatar.glb\n  doppel bench ada/avatar.glb --clip walk.bvh --time 1.5 --json ada.jsonl\n  doppel "
        "bench guitar.compressed.ply --axes y-down");
    command->callback([options, &run] {
        run = [options] {
            BenchExtras none;
            const Status done = runBench(*options, sdkContestant, none);
            return done ? int(kExitOk) : reportError(done.error());
        };
    });
}

}  // namespace dpl
