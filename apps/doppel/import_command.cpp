// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/doppel/video_options.h"
#include "apps/shared/checks.h"
#include "reconstruction/input/capture/person_height.h"
#include "reconstruction/input/import/import.h"
#include "reconstruction/run/progress.h"

namespace dpl {

void addImportCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<ImportOptions>();
    CLI::App* command = app.add_subcommand("import", "Make a scan folder from videos, photos or the files of a scanner app");
    CLI::Option* source = command->add_option("source", options->source, "Folder or file; docs/formats/captures.md lists what is read");
    command->add_option("-o,--out", options->out, "Scan folder to make: new, or empty")->required();
    addVideoOptions(*command, options->videos, source);
    command->add_option("--static-frames", options->counts.still, "Most frames of the still subject")
        ->check(inRange(1, 2000))
        ->capture_default_str();
    command->add_option("--closeup-frames", options->counts.closeup, "Most frames of close-ups")
        ->check(inRange(1, 2000))
        ->capture_default_str();
    command->add_option("--motion-frames", options->counts.moving, "Most frames of motion")->check(inRange(1, 2000))->capture_default_str();
    command->add_option("--long-side", options->longSidePx, "Pixels of the longer side to which videos and photos are reduced")
        ->check(inRange(64, 8192))
        ->capture_default_str();
    command
        ->add_option("--height", options->heightM,
                     "Height of the subject in metres, without shoes; sets the scale where cameras are not in metres")
        ->check(inRange(kShortestPersonM, kTallestPersonM));
    command->footer(
        "Examples:\n"
        "  doppel import walk.mp4 -o scan                one video: the subject stands still, then moves\n"
        "  doppel import --static orbit.mp4 --closeup face.mov hand.mov --motion moves.mp4 -o scan --height 1.74\n"
        "  doppel import photos -o scan                  a folder of JPEG photos\n"
        "  doppel import polycam-export -o scan          keyframes with cameras; also Record3D, NeRFCapture, nerfstudio, COLMAP\n"
        "  doppel import studio/Calib.qca.txt -o scan    synchronised videos of calibrated cameras beside the file\n"
        "Writes everything or nothing. Videos and photos give a scan without cameras; `doppel reconstruct` finds them.");
    command->callback([options, &run] {
        run = [options] {
            if (options->source.empty() && !anyVideo(options->videos)) return reportError(missingSource());
            Progress progress;
            progress.beginStage("import");
            auto done = importCapture(*options, &progress.cancelFlag(), [&](double share, const std::string& what) {
                progress.update(share, what);
                return !progress.cancelled();
            });
            if (!done) return reportError(done.error());
            progress.endStage("done");
            std::printf("%s\n%s\n", done->summary.c_str(), done->nextStep.c_str());
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
