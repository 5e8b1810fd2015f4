// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/progress.h"
#include "reconstruction/subject/sample/sample_avatar.h"
#include "sdk/core/files.h"

namespace dpl {

void addSampleAvatarCommand(CLI::App& app, CommandRun& run) {
    struct Options {
        std::filesystem::path out;
        uint64_t seed = 1;
        uint32_t threadCount = 0;
        bool skirt = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command =
        app.add_subcommand("sample-avatar", "Make an avatar of a procedural person at once, without a scan, to try the rest with");
    command->add_option("-o,--out", options->out, "Avatar file to write (.glb)")->required()->check(isOutputFile({".glb"}));
    command->add_option("--seed", options->seed, "Which person: shape, colours, clothes, motion")
        ->check(isWholeNumber())
        ->capture_default_str();
    command->add_flag("--skirt", options->skirt, "A wide skirt, in place of shorts");
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core. The file is the same for any number")
        ->check(inRange(0, 256));
    command->footer(
        "The clips inside are called walk and moves.\n"
        "Examples:\n  doppel sample-avatar -o ada.glb\n  doppel render ada.glb -o ada.png\n"
        "  doppel render ada.glb -o walk.mp4 --clip walk --seconds 5\n  doppel sample-avatar -o ben.glb --seed 7 --skirt");
    command->callback([options, &run] {
        run = [options] {
            Progress progress;
            Jobs jobs(options->threadCount);
            progress.beginStage("sample-avatar");
            const Subject subject = makeSubject(options->seed, jobs, options->skirt ? Bottom::Skirt : Bottom::Shorts);
            const Result<std::vector<uint8_t>> file = makeSampleAvatarFile(subject, jobs);
            if (!file) return reportError(file.error());
            if (const Status written = writeFileAtomically(options->out, *file); !written) return reportError(written.error());
            progress.endStage(formatText("{}: {} KB, with the clips walk and moves", options->out.string(), file->size() / 1000));
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
