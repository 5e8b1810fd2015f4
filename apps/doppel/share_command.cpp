// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/beside_tool.h"
#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/share.h"

namespace dpl {

void addShareCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<ShareOptions>();
    CLI::App* command = app.add_subcommand("share", "Write one page with the person alive in it, to open in a browser or to send");
    command->add_option("avatar", options->from, "Output folder of doppel reconstruct, or an avatar file (.glb)")->required();
    command->add_option("-o,--out", options->out, "The page to write (.html)")->required()->check(isOutputFile({".html"}));
    command->add_option("--name", options->name, "Who it is; default: as the page is called");
    command->add_option("--licence", options->licence, "What others may do with it, such as CC0-1.0; default: none is stated");
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core. The page is the same for any number")
        ->check(inRange(0, 256));
    command->footer(
        "Examples:\n"
        "  doppel share ada -o ada.html\n"
        "  doppel share ada/avatar.glb -o page.html --name Ada --licence CC-BY-4.0\n"
        "The page needs no network and no other file. It holds the avatar and nothing of its scan: no photographs, no name of the scan.\n"
        "Who gets it can take the avatar out of it. The person moves by the clips of the file and by two walks.\n"
        "Needs the web module, which the package doppel-tools brings and tools/prove-web --build makes in the source tree.");
    command->callback([options, &run] {
        refuseInputAsOutput(options->out, {options->from});
        run = [options] {
            options->web = webFolder();
            const auto line = shareAvatar(*options);
            if (!line) return reportError(line.error());
            std::printf("%s\n", line->c_str());
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
