// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/bench.h"

#include <algorithm>
#include <cstdio>

#include "apps/bench/tables.h"
#include "apps/shared/checks.h"
#include "apps/shared/pictures.h"
#include "reconstruction/run/progress.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr BenchCase kCases[] = {{"scan 378x504", 378, 504, 1},
                                {"phone 945x2048", 945, 2048, 1},
                                {"portrait 945x945", 945, 945, 1, true},
                                {"headset 1920x1824 stereo", 1920, 1824, 2}};

constexpr const char* kMeanings =
    "\nms: dplDraw and dplReadImages together, until the pictures are in memory; median and 95th percentile. dplDraw ms: what an app's\n"
    "thread pays. GPU ms: the frame's passes by the device's clock. PSNR and max error: against the double-precision referee, colour over\n"
    "mid grey, of all pixels and of the covered ones. FLIP: mean over covered pixels, 0 to 1. Warm frames: C++ heap allocations of\n"
    "dplSetPose and dplDraw, and waits of dplDraw, of all timed frames and of three more in flight together.\n"
    "PLY: 62 floats a splat. Splats: codes, parents and SH entries. Avatar: also mesh, weights and pose correctives, CPU and GPU "
    "together.\n"
    "Working set: bytes that the frames of a case add. Bytes read: of the splats' codes, a splat, over all views; phase 1 decides which\n"
    "splats may show, phase 2 decodes those. The CPU counts them; for a GPU they follow from survivors and layout.\n";

Status writePlot(const BenchOptions& options, const std::vector<PlotSeries>& plot) {
    const PlotOptions axes{"Speed against error: left is faster, up is nearer to the referee",
                           "ms a frame, median",
                           "PSNR of covered pixels, dB",
                           true,
                           false,
                           900,
                           460,
                           true};
    return writeFileAtomically(options.plotFile, svgFile(svgPlot(plot, axes)));
}

void printAutoFill(const BenchOptions& options) {
    if (std::all_of(options.renderers.begin(), options.renderers.end(), [](const std::string& name) { return name == "software"; })) return;
    if (auto chosen = doppel::Context::create(DPL_RENDERER_VULKAN))
        std::printf("What --fill auto chooses on this device: %s\n", chosen->rendererName().c_str());
}

}  // namespace

void addBenchOptions(CLI::App& command, BenchOptions& options, const std::vector<std::string>& renderers) {
    command
        .add_option("avatar", options.avatar,
                    "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")
        ->required();
    command.add_option("--renderers", options.renderers, "The renderers to time")->check(CLI::IsMember(renderers))->capture_default_str();
    command.add_option("--fill", options.fill, "How the renderer 'vulkan' fills pixels; auto: a self-test finds the faster way")
        ->check(CLI::IsMember(kFillNames))
        ->capture_default_str();
    command.add_option("--clip", options.clip, "Pose: a clip of the avatar by name, or a BVH or glTF file (default: the rest pose)");
    command.add_option("--time", options.timeS, "Pose: time in the clip, seconds")->check(inRange(0.0, 1e6));
    command.add_option("--repeats", options.repeats, "Number of timed frames in each case")->check(inRange(1, 1000))->capture_default_str();
    command.add_option("--threads", options.threadCount, "CPU threads; 0: one for each core")->check(inRange(0, 256));
    command.add_option("--axes", options.axes, kAxesHelp)->check(CLI::IsMember(kAxesNames));
    command.add_option("--json", options.jsonFile, "Also write the figures to this file, as JSON lines");
    CLI::Option* withoutReference = command.add_flag("--no-reference", options.withoutReference,
                                                     "Measure no errors, only times; the referee takes seconds for each picture");
    command.add_option("--plot", options.plotFile, "Draw speed against error into this SVG file")->excludes(withoutReference);
}

Status runBench(const BenchOptions& options, const ContestantMaker& make, BenchExtras& extras) {
    DPL_TRY(const BenchSubject subject, BenchSubject::load(options));
    DPL_TRY(const ReferenceFile referee, ReferenceFile::read(subject.bytes));
    Progress progress;
    BenchText text{!options.withoutReference, subject.info.splatCount, {}, {}, {}};
    std::vector<PlotSeries> plot;
    std::vector<PassTable> passes;
    Status warm;  // first error of checkWarmFrames; returned after the tables are printed
    for (BenchCase test : kCases) {
        test.widthPx /= options.shrink, test.heightPx /= options.shrink;
        const std::vector<Cameraf> views = subject.views(test, options.axes);
        DPL_TRY(std::vector<Contestant> list, contestants(make, options, subject, views));
        const auto report = [&](const char* what) {
            return [&progress, what, &test](double share) -> Status {
                progress.update(share, formatText("{}, {}", test.name, what));
                return progress.cancelled() ? Status(fail(Code::Cancelled, "stopped")) : Status();
            };
        };
        progress.beginStage("frames");
        DPL_RETURN_IF_ERROR(timeFrames(list, subject, options.repeats, report("timing")));
        progress.endStage(test.name);
        if (!options.withoutReference) {
            progress.beginStage("referee");
            DPL_RETURN_IF_ERROR(measureErrors(list, subject, views, referee, report("drawing in double precision")));
            progress.endStage(test.name);
        }
        for (const Contestant& c : list) {
            text.add(test, c, referee.samples(subject.root, views[0]));
            addPasses(passes, c, test);
            addPoint(plot, c, test);
        }
        extras.add(test, list, subject, referee);
        if (warm) warm = checkWarmFrames(list, test);
    }
    std::printf("%s: %u splats, %zu bytes in the file; %u timed frames a case\n\n%s", options.avatar.c_str(), subject.info.splatCount,
                subject.bytes.size(), options.repeats, text.framesTable().c_str());
    for (const PassTable& table : passes) std::printf("%s", table.text().c_str());
    std::printf("%s%s", text.memoryTable().c_str(), kMeanings);
    printAutoFill(options);
    std::printf("%s", extras.text().c_str());
    if (!options.plotFile.empty()) {
        DPL_RETURN_IF_ERROR(writePlot(options, plot));
    }
    if (!options.jsonFile.empty()) {
        DPL_RETURN_IF_ERROR(writeFileAtomically(options.jsonFile, text.json + extras.json()));
    }
    return warm;
}

}  // namespace dpl
