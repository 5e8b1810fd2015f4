// SPDX-License-Identifier: Apache-2.0
// doppel bench: compares time, error and memory of every renderer that a user can choose, on one avatar. doppel bench training: measures
// training steps.
#include "apps/bench/bench.h"
#include "apps/bench/training.h"
#include "apps/doppel/commands.h"
#include "apps/doppel/scan_options.h"
#include "apps/shared/checks.h"

namespace dpl {
namespace {

void addTrainingCommand(CLI::App& bench, CommandRun& run) {
    auto options = std::make_shared<TrainingBenchOptions>();
    CLI::App* command = bench.add_subcommand(
        "training", "Measure steps of the training of `doppel reconstruct` by part, as slow as its last ones: all splats, full size");
    CLI::Option* scan = command->add_option("scan", options->reconstruct.scan, "Scan to train on; default: the procedural subject");
    CLI::Option* out =
        command->add_option("-o,--out", options->reconstruct.out, "Output folder of the scan's run, whose stages are used")->needs(scan);
    scan->needs(out);
    command->add_option("--size", options->size, "Size of the procedural subject's pictures")
        ->check(isPictureSize())
        ->capture_default_str()
        ->excludes(scan);
    command->add_option("--seed", options->reconstruct.seed, "Seed of the procedural subject and of the training")
        ->check(isWholeNumber())
        ->capture_default_str();
    command->add_option("--splats", options->steps.splats, "Number of splats; 0: that of the preset standard")
        ->check(inRange(0, 10000000))
        ->capture_default_str();
    command->add_option("--steps", options->steps.steps, "Steps to measure")->check(inRange(1, 100000))->capture_default_str();
    command->add_option("--warm-up", options->steps.warmUp, "Steps before them")->check(inRange(0, 100000))->capture_default_str();
    command->add_option("--threads", options->reconstruct.threadCount, "CPU threads; 0: one for each core")
        ->check(inRange(0, 256))
        ->capture_default_str();
    addEngineOption(*command, options->reconstruct);
    command->add_option("--json", options->jsonFile, "Also write the figures to this file, as JSON lines");
    command->footer(
        "Examples:\n  doppel bench training\n  doppel bench training --size 1080x1440 --splats 300000 --steps 12\n"
        "  doppel bench training scan -o ada --json steps.jsonl\n  doppel bench training --engine gpu");
    command->callback([options, &run] {
        run = [options] {
            const Status done = runTrainingBench(*options);
            return done ? int(kExitOk) : reportError(done.error());
        };
    });
}

}  // namespace

void addBenchCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<BenchOptions>();
    options->renderers = {"software", "vulkan-quads", "vulkan-tiles"};
    CLI::App* command =
        app.add_subcommand("bench", "Time an avatar on every renderer and measure its pictures against the double-precision referee");
    addBenchOptions(*command, *options, {"software", "vulkan", "vulkan-quads", "vulkan-tiles"});
    command->get_option("avatar")->required(false);  // doppel bench training takes none
    addTrainingCommand(*command, run);
    command->footer(
        "Examples:\n  doppel bench ada/avatar.glb\n  doppel bench ada/avatar.glb --clip walk.bvh --time 1.5 --json ada.jsonl\n  doppel "
        "bench guitar.compressed.ply --axes y-down");
    command->callback([command, options, &run] {
        if (!command->get_subcommands().empty()) return;
        if (options->avatar.empty()) throw CLI::RequiredError("avatar");
        run = [options] {
            BenchExtras none;
            const Status done = runBench(*options, sdkContestant, none);
            return done ? int(kExitOk) : reportError(done.error());
        };
    });
}

}  // namespace dpl
