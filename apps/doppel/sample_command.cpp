// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/progress.h"
#include "reconstruction/subject/sample/scan_writer.h"

namespace dpl {

void addSampleCommand(CLI::App& app, CommandRun& run) {
    struct Options {
        std::filesystem::path out;
        uint64_t seed = 1;
        uint32_t threadCount = 0;
        bool small = false, skirt = false, fingers = false, chart = false, posters = false;
        std::string size, hair;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("sample", "Make the scan of a procedural person, with the true shape and poses");
    command->add_option("-o,--out", options->out, "Scan folder to make; if it exists it must be empty")->required();
    command->add_option("--seed", options->seed, "Which person: shape, colours, clothes, motion")
        ->check(isWholeNumber())
        ->capture_default_str();
    command->add_flag("--small", options->small, "Pictures of half the size and fewer frames, for quick tests");
    command->add_option("--size", options->size, "Size of the pictures; default 378x504, with --small 189x252")->check(isPictureSize());
    command->add_flag("--skirt", options->skirt, "A wide skirt that swings, in place of shorts");
    command
        ->add_option("--hair", options->hair,
                     "Locks of hair in place of a close cap: short, or long, which swings; the head shakes then too")
        ->check(CLI::IsMember({"short", "long"}));
    command->add_flag("--fingers", options->fingers, "Hands that bend and make gestures, with keypoints of every finger");
    command->add_flag("--chart", options->chart, "A test chart on the shirt: letters, bars and a check, of 26 to 0.6 mm");
    command->add_flag("--posters", options->posters, "A room with posters and a patterned floor, in which cameras can be found");
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core. The files are the same for any number")
        ->check(inRange(0, 256));
    command->footer(
        "Examples:\n  doppel sample -o scan\n  doppel sample -o scan-7 --seed 7 --small\n"
        "  doppel sample -o scan-2k --size 1080x1440 --chart    as many pixels as a phone's video, and fine print\n"
        "  doppel sample -o scan-skirt --skirt          cloth that hangs free between the legs\n"
        "  doppel sample -o scan-hair --hair long       hair that hangs, swings, and swings on\n"
        "  doppel sample -o scan-hands --fingers        fingers that move\n"
        "  doppel sample -o scan-room --posters         to try `doppel cameras`; then take the cameras out of scan.json");
    command->callback([options, &run] {
        run = [options] {
            Progress progress;
            Jobs jobs(options->threadCount);
            SampleScanOptions scan = SampleScanOptions::small(options->seed);
            if (!options->small) scan = SampleScanOptions{}, scan.seed = options->seed;
            scan.skirt = options->skirt, scan.fingers = options->fingers, scan.chart = options->chart, scan.posters = options->posters;
            if (!options->hair.empty()) scan.hair = options->hair == "long" ? Hairstyle::Long : Hairstyle::Short;
            if (const auto size = parsePictureSize(options->size)) scan.widthPx = size->widthPx, scan.heightPx = size->heightPx;
            progress.beginStage("sample");
            ShownTask task(progress);
            const TaskScope scope(&task);
            const Status made = makeSampleScan(options->out, scan, jobs);
            if (!made) return reportError(made.error());
            progress.endStage(
                formatText("{} frames in {}", scan.fullFrames + scan.closeupFrames + scan.dynamicFrames, options->out.string()));
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
