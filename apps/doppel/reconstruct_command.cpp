// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/commands.h"
#include "apps/doppel/talk.h"
#include "apps/doppel/video_options.h"
#include "apps/shared/checks.h"
#include "reconstruction/pipeline/reconstruct.h"

namespace dpl {

void addReconstructCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<ReconstructOptions>();
    CLI::App* command = app.add_subcommand("reconstruct", "Make an avatar from a scan folder");
    CLI::Option* scan = command->add_option(
        "scan", options->scan, "Scan folder (docs/formats/scan.md), nerfstudio or COLMAP folder, or anything that `doppel import` reads");
    addVideoOptions(*command, options->videos, scan);
    command->add_option("-o,--out", options->out, "Output folder: avatar.glb, poses.json, report.html and the stages")->required();
    command->add_option("--body", options->body, "Body to start from (.glb made by `doppel body import`); default: the built-in body");
    command->add_option("--models", options->models,
                        "Folder of ONNX networks that find keypoints, masks and clothing if the scan has none; default: where tools/models "
                        "installs them");
    command
        ->add_option(
            "--person", options->persons,
            "FRAME:X,Y: the person is at this pixel of this picture, where several are in view; once for the still and once for the "
            "moving pictures")
        ->allow_extra_args(false);
    command
        ->add_option("--height", options->heightM,
                     "Height of the subject in metres, without shoes; sets the scale of a scan whose cameras have to be found")
        ->check(inRange(0.3, 2.8));
    const auto choosePreset = [options](const std::string& name) {
        options->preset = name == "draft" ? Preset::Draft : name == "high" ? Preset::High : Preset::Standard;
    };
    command->add_option_function<std::string>("--preset", choosePreset, "Quality against time: draft takes minutes")
        ->check(CLI::IsMember({"draft", "standard", "high"}))
        ->default_str("standard");
    command
        ->add_option("--time-budget", options->timeBudgetMinutes,
                     "Minutes for training; a timed probe at the start turns them into a number of steps")
        ->check(inRange(0.0, 1e5));
    command->add_option("--steps", options->steps, "Number of training steps instead of the preset's, for comparisons")
        ->check(inRange(0, 10000000))
        ->excludes("--time-budget");
    command->add_option("--seed", options->seed, "Seed of every random choice; same seed, same bytes")->capture_default_str();
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core. The result is the same for any number")
        ->check(inRange(0, 256))
        ->capture_default_str();
    const auto leaveOut = [options](const std::vector<std::string>& parts) {
        for (const std::string& part : parts)
            (part == "layers"        ? options->without.layers
             : part == "large-steps" ? options->without.largeSteps
             : part == "light"       ? options->without.light
                                     : options->without.gradientControl) = true;
    };
    command
        ->add_option_function<std::vector<std::string>>("--without", leaveOut,
                                                        "Leave parts of the method out, to measure what they bring (tools/ablations)")
        ->check(CLI::IsMember({"layers", "large-steps", "light", "gradient-control"}))
        ->delimiter(',');
    const auto talk = addTalkOptions(*command);
    command->footer(
        "Examples:\n"
        "  doppel reconstruct scan -o ada\n"
        "  doppel reconstruct scan -o ada --preset draft\n"
        "  doppel reconstruct polycam-export -o ada            (imported into ada/scan first; see doppel import --help)\n"
        "  doppel reconstruct orbit -o him     (pictures and cameras only: the networks of tools/models find the rest)\n"
        "Ctrl-C or a kill loses at most one checkpoint interval; the same command continues.");
    command->callback([options, talk, &run] {
        run = [options, talk] {
            if (options->scan.empty() && !anyVideo(options->videos)) return talk->fail(missingSource());
            Progress progress(talk->style());
            const auto result = reconstruct(*options, progress);
            if (!result) return talk->fail(result.error());
            nlohmann::json stages = nlohmann::json::array();
            for (const StageRecord& s : result->stages)
                stages.push_back({{"name", s.name}, {"seconds", s.seconds}, {"peakBytes", s.peakBytes}, {"reused", s.reused}});
            return talk->succeed(result->summary + "\nopen " + result->report.string(),
                                 {{"avatar", result->avatar.string()},
                                  {"poses", result->poses.string()},
                                  {"report", result->report.string()},
                                  {"figures", (options->out / "report.json").string()},
                                  {"stages", stages}});
        };
    });
}

}  // namespace dpl
