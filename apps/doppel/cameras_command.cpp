// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "reconstruction/input/capture/person_height.h"
#include "reconstruction/run/find_cameras.h"

namespace dpl {

void addCamerasCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<FindCamerasOptions>();
    CLI::App* command =
        app.add_subcommand("cameras", "Find the cameras of a scan that brings none, or repair bad ones, as `doppel reconstruct` does");
    command->add_option("scan", options->scan, "Scan folder (docs/formats/scan.md)")->required();
    command->add_option("-o,--out", options->out, "Output folder; `doppel reconstruct` with the same folder goes on from there")
        ->required();
    command->add_option("--height", options->heightM, "Height of the subject in metres, without shoes; sets the scale")
        ->check(inRange(kShortestPersonM, kTallestPersonM));
    command->add_option("--truth", options->truth, "Scan with the true cameras: prints how far the cameras are from them");
    command->footer(
        "Scans without cameras need COLMAP (apt-get install colmap).\n"
        "Examples:\n"
        "  doppel cameras walk -o ada\n"
        "  doppel cameras walk -o ada --height 1.74\n"
        "  doppel cameras scan-without -o test --truth scan");
    command->callback([options, &run] {
        refuseInputAsOutput(options->out, {options->scan, options->truth});
        run = [options] {
            Progress progress;
            const auto summary = findCameras(*options, progress);
            if (!summary) return reportError(summary.error());
            std::printf("%s", summary->c_str());
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
