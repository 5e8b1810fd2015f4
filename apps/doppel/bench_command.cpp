// SPDX-License-Identifier: Apache-2.0
// doppel bench: time, error and bytes of every renderer on an avatar, side by side.
#include <algorithm>
#include <cstdio>

#include "apps/doppel/bench_contestants.h"
#include "apps/doppel/bench_tables.h"
#include "apps/doppel/bench_worth.h"
#include "apps/doppel/checks.h"
#include "apps/doppel/commands.h"
#include "apps/doppel/pictures.h"
#include "reconstruction/pipeline/progress.h"
#include "sdk/core/files.h"
#include "tests/reference/reference_file.h"

namespace dpl {
namespace {

constexpr BenchCase kCases[] = {{"scan 378x504", 378, 504, 1},
                                {"phone 945x2048", 945, 2048, 1},
                                {"portrait 945x945", 945, 945, 1, true},
                                {"headset 1920x1824 stereo", 1920, 1824, 2}};

constexpr const char* kMeanings =
    "\nPLY: 62 floats a splat. Splats: codes, parents, SH entries; of plain float its records. Avatar: with mesh, weights and pose "
    "correctives, CPU and GPU together. Working set: what the frames of this case add.\n"
    "Bytes read, of the splats' codes, over all splats and views: to tell which may show, and of those; counted on the CPU, from survivors "
    "and layout on a GPU.\n";

Status bench(const BenchOptions& options) {
    DPL_TRY(const BenchSubject subject, BenchSubject::load(options));
    DPL_TRY(const ReferenceFile referee, ReferenceFile::read(subject.bytes));
    Progress progress;
    BenchText text{!options.withoutReference, subject.info.splatCount, {}, {}, {}};
    BenchWorth worth{!options.withoutReference, {}, {}};
    std::string model;
    std::vector<PlotSeries> plot;
    std::vector<PassTable> passes;
    Status warm;  // the tables are printed all the same
    for (const BenchCase& test : kCases) {
        const std::vector<Cameraf> views = subject.views(test, options.axes);
        DPL_TRY(std::vector<Contestant> list, contestants(options, subject, test, views));
        const auto report = [&](const char* what) {
            return [&progress, what, &test](double share) -> Status {
                progress.update(share, formatText("{}, {}", test.name, what));
                return progress.cancelled() ? Status(fail(Code::Cancelled, "stopped")) : Status();
            };
        };
        progress.beginStage("frames");
        DPL_CHECK_OK(timeFrames(list, subject, options.repeats, report("timing")));
        progress.endStage(test.name);
        if (!options.withoutReference) {
            progress.beginStage("reference");
            DPL_CHECK_OK(measureErrors(list, subject, views, referee, report("drawing in double precision")));
            progress.endStage(test.name);
        }
        for (const Contestant& c : list) {
            text.add(test, c, referee.samples(subject.root, views[0]));
            addPasses(passes, c, test);
            addPoint(plot, c, test);
        }
        worth.add(test, list);
        model += modelOf(test, list, subject, referee.hasPoseCorrectives(), options.model);
        if (warm) warm = checkWarmFrames(list, test);
    }
    std::printf("%s: %u splats, %zu bytes in the file\n\n%s", options.avatar.c_str(), subject.info.splatCount, subject.bytes.size(),
                text.framesTable().c_str());
    for (const PassTable& table : passes) std::printf("%s", table.text().c_str());
    std::printf("%s%s%s", worth.text().c_str(), text.memoryTable().c_str(), kMeanings);
    std::printf(
        "\nms: dplDraw and dplReadImages together, pictures in memory; median and 95th percentile of %u. dplDraw ms: what an app's thread "
        "pays. GPU ms: the frame's passes by the device's clock. PSNR and max error: against the\n"
        "double-precision reference, colour over mid grey; of all pixels, and of those that something covers. FLIP: mean over covered "
        "pixels, 0 to 1. Warm frames: C++ heap allocations of dplSetPose and dplDraw, and waits of\n"
        "dplDraw, of all timed frames and three more in flight together. Worth: the ratio of each round, median and quartiles. Plain "
        "float: the frozen frame of tests/baseline, before any optimisation, always one sample a pixel.\n",
        options.repeats);
    const bool raced =
        std::any_of(options.renderers.begin(), options.renderers.end(), [](const std::string& name) { return name != "software"; });
    if (auto chosen = raced ? doppel::Context::create(DPL_RENDERER_VULKAN) : doppel::Error{})
        std::printf("What --fill auto chooses on this device: %s\n", chosen->rendererName().c_str());
    if (!model.empty())
        std::printf(
            "\nA MODEL, NOT A MEASUREMENT (docs/model.md): bytes that each pass moves and operations that it does, from counted survivors, "
            "at %g GB/s and %g GFLOP/s, the longer of the two; no caches, no blending, no pixels of quads.\n\n"
            "| case, today's fill | pass | plain float: MB read + written | 10⁶ operations | expected ms | today: MB read + written | 10⁶ "
            "operations | expected ms |\n|---|---|---|---|---|---|---|---|\n%s",
            options.model.gbps, options.model.gflops, model.c_str());
    if (!options.plotFile.empty()) {
        const PlotOptions axes{"Speed against error: left is faster, up is nearer to the reference",
                               "ms a frame, median",
                               "PSNR of covered pixels, dB",
                               true,
                               false,
                               900,
                               460,
                               true};
        DPL_CHECK_OK(writeFileAtomically(options.plotFile, svgFile(svgPlot(plot, axes))));
    }
    if (!options.jsonFile.empty()) {
        DPL_CHECK_OK(writeFileAtomically(options.jsonFile, text.json));
    }
    return warm;
}

}  // namespace

void addBenchCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<BenchOptions>();
    options->renderers = defaultBenchRenderers();
    CLI::App* command =
        app.add_subcommand("bench", "Time an avatar on every renderer and measure its pictures against the double-precision reference");
    command
        ->add_option("avatar", options->avatar,
                     "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")
        ->required();
    command->add_option("--renderers", options->renderers, "Which to race")->check(CLI::IsMember(benchRenderers()))->capture_default_str();
    command
        ->add_option(
            "--fill", options->fill,
            "How vulkan and what has something switched off fill pixels; auto: a self-test finds the faster one, quads for the latter")
        ->check(CLI::IsMember(kFillNames))
        ->capture_default_str();
    command->add_option("--clip", options->clip, "Pose: a clip of the avatar by name, or a BVH or glTF file (default: the rest pose)");
    command->add_option("--time", options->timeS, "Pose: time in the clip, seconds")->check(inRange(0.0, 1e6));
    command->add_option("--repeats", options->repeats, "Timed frames a case")->check(inRange(1, 1000))->capture_default_str();
    command->add_option("--threads", options->threadCount, "CPU threads, 0: one a core")->check(inRange(0, 256));
    command->add_option("--axes", options->axes, "How the file stands; many 3D Gaussian splatting PLYs are y-down")
        ->check(CLI::IsMember(kAxesNames))
        ->capture_default_str();
    command
        ->add_option_function<std::pair<double, double>>(
            "--model",
            [options](const std::pair<double, double>& m) {
                options->model = {m.first, m.second};
            },
            formatText("The machine of the model table (docs/model.md): 10^9 bytes and 10^9 operations a second; {} {} without it",
                       options->model.gbps, options->model.gflops))
        ->check(inRange(0.1, 1e6));
    command->add_option("--json", options->jsonFile, "Write the figures to this file as JSON lines too");
    CLI::Option* withoutReference =
        command->add_flag("--no-reference", options->withoutReference, "Only time: the reference takes seconds a picture");
    command->add_option("--plot", options->plotFile, "Draw speed against error into this SVG file")->excludes(withoutReference);
    command->footer(
        "Examples:\n  doppel bench ada/avatar.glb\n  doppel bench ada/avatar.glb --clip walk.bvh --time 1.5 --json ada.jsonl\n  doppel "
        "bench guitar.compressed.ply --axes y-down");
    command->callback([options, &run] {
        run = [options] {
            Status done = bench(*options);
            return done ? int(kExitOk) : reportError(done.error());
        };
    });
}

}  // namespace dpl
