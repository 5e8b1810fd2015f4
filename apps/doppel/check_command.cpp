// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/commands.h"
#include "apps/doppel/scan_options.h"
#include "apps/doppel/talk.h"
#include "reconstruction/run/first_look.h"
#include "reconstruction/run/reconstruct.h"

namespace dpl {

void addCheckCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<ReconstructOptions>();
    CLI::App* command = app.add_subcommand("check", "Say what to film again, before an avatar is made");
    addScanOptions(*command, *options, "Output folder for verdict.json; `doppel reconstruct` with the same folder goes on from there");
    const auto talk = addTalkOptions(*command);
    command->footer(
        "First looks at a sample of the pictures, which takes about a minute: blur, darkness, missing sides, cut feet, hands, moves.\n"
        "Then fits a body to all of them and maps how finely, how often and how sharply they show each place of it.\n"
        "Examples:\n"
        "  doppel check scan -o ada\n"
        "  doppel check --static orbit.mp4 --closeup face.mov -o ada\n"
        "docs/guides/capture.md says how to film.");
    command->callback([options, talk, &run] {
        refuseInputAsOutput(options->out, {options->scan});
        run = [options, talk] {
            if (options->scan.empty() && !anyVideo(options->videos)) return talk->fail(missingSource());
            Progress progress(talk->style());
            nlohmann::json firstLook = nlohmann::json::array();
            const auto look = takeFirstLook(*options, progress);
            if (!look) return talk->fail(look.error());
            if (*look) {
                for (const FilmFault& fault : (*look)->faults) firstLook.push_back({{"fault", fault.key}, {"sentence", fault.sentence}});
                progress.note((*look)->text());
            }
            const auto advice = checkFilm(*options, progress);
            if (!advice) return talk->fail(advice.error());
            return talk->succeed(advice->substr(0, advice->find_last_not_of('\n') + 1),
                                 {{"advice", *advice}, {"first_look", firstLook}, {"verdict", (options->out / "verdict.json").string()}});
        };
    });
}

}  // namespace dpl
