// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/beside_tool.h"
#include "apps/doppel/commands.h"
#include "apps/doppel/scan_options.h"
#include "apps/doppel/talk.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/reconstruct.h"

namespace dpl {

void addReconstructCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<ReconstructOptions>();
    CLI::App* command = app.add_subcommand("reconstruct", "Make an avatar from a scan folder");
    addScanOptions(*command, *options, "Output folder: avatar.glb, poses.json, report.html and the stages");
    const auto choosePreset = [options](const std::string& nameOrFile) {
        auto found = findPreset(nameOrFile);
        if (!found) throw CLI::ValidationError("--preset", found.error().message);
        options->preset = std::move(*found);
    };
    command
        ->add_option_function<std::string>("--preset", choosePreset,
                                           "Quality against time: draft takes minutes. Or a file with your own numbers (doppel presets)")
        ->type_name("TEXT:{draft,standard,high}|FILE.json")
        ->default_str("standard");
    command
        ->add_option("--time-budget", options->timeBudgetMinutes,
                     "Minutes from the scan to the report, about; a timed probe turns what is left at the training into a number of steps")
        ->check(inRange(0.0, 1e5));
    command->add_option("--steps", options->steps, "Number of training steps instead of the preset's, for comparisons")
        ->check(inRange(0, 10000000))
        ->excludes("--time-budget");
    command
        ->add_option(
            "--from", options->from,
            "A checkpoint of a stopped run of this scan (OUT/stages/co-optimise.work/checkpoint): training goes on from it with the "
            "settings of this run, and says what changed")
        ->type_name("CHECKPOINT")
        ->check(CLI::ExistingFile)
        ->excludes("--time-budget");
    command->add_option("--checkpoint-every", options->checkpointS, "Seconds of training that a kill may lose")
        ->check(inRange(0.0, 1e5))
        ->capture_default_str();
    addEngineOption(*command, *options);
    command->add_option("--seed", options->seed, "Seed of every random choice; same seed, same bytes")
        ->check(isWholeNumber())
        ->capture_default_str();
    const auto leaveOut = [options](const std::vector<std::string>& parts) {
        for (const std::string& part : parts)
            (part == "layers"        ? options->without.layers
             : part == "large-steps" ? options->without.largeSteps
             : part == "light"       ? options->without.light
             : part == "motion"      ? options->without.motion
                                     : options->without.gradientControl) = true;
    };
    command
        ->add_option_function<std::vector<std::string>>("--without", leaveOut,
                                                        "Leave parts of the method out, to measure what they bring (tools/ablations)")
        ->check(CLI::IsMember({"layers", "large-steps", "light", "motion", "gradient-control"}))
        ->delimiter(',');
    const auto talk = addTalkOptions(*command);
    command->footer(
        "Examples:\n"
        "  doppel reconstruct scan -o ada\n"
        "  doppel reconstruct scan -o ada --preset draft\n"
        "  doppel presets high -o mine.json && doppel reconstruct scan -o ada --preset mine.json      (your own numbers)\n"
        "  cp -r ada bob && doppel reconstruct scan -o bob --from ada/stages/co-optimise.work/checkpoint --preset mine.json\n"
        "  doppel reconstruct polycam-export -o ada            (imported into ada/scan first; see doppel import --help)\n"
        "  doppel reconstruct orbit -o him     (pictures and cameras only: the networks of tools/models find the rest)\n"
        "Ctrl-C or a kill loses at most one checkpoint interval; the same command continues. doppel-viewer ada shows how far it is.");
    command->callback([options, talk, &run] {
        refuseInputAsOutput(options->out, {options->scan});
        run = [options, talk] {
            if (options->scan.empty() && !anyVideo(options->videos)) return talk->fail(missingSource());
            options->web = webFolder();
            Progress progress(talk->style());
            const auto result = reconstruct(*options, progress);
            if (!result) return talk->fail(result.error());
            nlohmann::json stages = nlohmann::json::array();
            for (const StageRecord& s : result->stages)
                stages.push_back({{"name", s.name}, {"seconds", s.seconds}, {"peakBytes", s.peakBytes}, {"reused", s.reused}});
            return talk->succeed((talk->verbose ? result->summary + "\n\n" : "") + result->words +
                                     formatText("\n{}: {} is done. Open {} to see it and what to film again.", result->word,
                                                result->avatar.string(), result->report.string()),
                                 {{"word", result->word},
                                  {"avatar", result->avatar.string()},
                                  {"poses", result->poses.string()},
                                  {"report", result->report.string()},
                                  {"figures", (options->out / "report.json").string()},
                                  {"stages", stages}});
        };
    });
}

}  // namespace dpl
